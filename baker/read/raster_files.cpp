#include "baker/read/raster_files.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <string_view>
#include <utility>

#include <cpl_conv.h>
#include <cpl_minixml.h>
#include <cpl_string.h>
#include <fmt/format.h>

#include "baker/read/gdal_file.h"

namespace fjell::baker {

namespace {

namespace fs = std::filesystem;

fs::file_status status_of(const std::string& path) {
    std::error_code ignored; // what cannot be looked at cannot be opened, and is said then
    return fs::status(path, ignored);
}

// A file, or those within a name such as /vsizip/a.zip/b.tif or NETCDF:"a.nc":height.
std::vector<std::string> files_named(const std::string& name) {
    if (fs::exists(status_of(name))) return {name};
    std::string rest = name;
    while (rest.starts_with("/vsi") && rest.find('/', 1) != std::string::npos) rest.erase(0, rest.find('/', 1) + 1);
    if (rest != name) {
        std::erase_if(rest, [](char c) { return c == '{' || c == '}'; });
        for (fs::path at = rest; !at.empty() && at != at.root_path(); at = at.parent_path())
            if (fs::exists(status_of(at.string()))) return {at.string()};
        return {};
    }
    std::vector<std::string> files;
    for (std::size_t from = 0; from < name.size();) {
        const std::size_t end = std::min(name.find_first_of(":\"", from), name.size());
        const std::string part = name.substr(from, end - from);
        if (!part.empty() && fs::exists(status_of(part))) files.push_back(part);
        from = end + 1;
    }
    return files;
}

struct CplFree {
    void operator()(CPLXMLNode* node) const { CPLDestroyXMLNode(node); }
};

bool is_vrt(const std::string& path) {
    char head[1024]; // as much as GDAL looks at
    std::ifstream file(path, std::ios::binary);
    file.read(head, sizeof head);
    return std::string_view(head, static_cast<std::size_t>(file.gcount())).find("<VRTDataset") !=
           std::string_view::npos;
}

class Sources {
public:
    void add(const std::string& name) {
        for (const std::string& file : files_named(name)) add_file(file);
    }
    std::vector<std::string> files;

private:
    void add_file(const std::string& path) {
        if (!seen_.insert(path).second) return;
        const fs::file_status status = status_of(path);
        if (!fs::is_regular_file(status) && !fs::is_directory(status))
            throw Failure(1, fmt::format("{}: not a regular file{}; give a file in its place", path,
                                         files.empty() ? "" : ", which " + files.front() + " needs"));
        files.push_back(path);
        if (!fs::is_regular_file(status) || !is_vrt(path)) return;
        const GdalMessages quiet; // what is wrong with it is said when it is opened
        const std::unique_ptr<CPLXMLNode, CplFree> xml(CPLParseXMLFile(path.c_str()));
        for (const CPLXMLNode* node = xml.get(); node; node = node->psNext) visit(*node, path);
    }

    void visit(const CPLXMLNode& node, const std::string& vrt) {
        if (node.eType != CXT_Element) return;
        if (EQUAL(node.pszValue, "SourceFilename") || EQUAL(node.pszValue, "SourceDataset")) {
            const char* const name = CPLGetXMLValue(&node, nullptr, "");
            const bool relative = CPLTestBool(CPLGetXMLValue(&node, "relativeToVRT", "0"));
            add(relative ? CPLProjectRelativeFilename(fs::path(vrt).parent_path().c_str(), name) : name);
            return;
        }
        for (const CPLXMLNode* child = node.psChild; child; child = child->psNext) visit(*child, vrt);
    }

    std::set<std::string> seen_;
};

} // namespace

std::vector<std::string> raster_sources(const std::string& path) {
    Sources sources;
    sources.add(path);
    return std::move(sources.files);
}

std::vector<std::string> raster_files(const std::string& path, const char* what) {
    std::vector<std::string> files = raster_sources(path);
    GdalMessages messages;
    const GdalFile file = open_raster(path, what, messages);
    const CPLStringList listed(file->GetFileList());
    // A VRT's list has its sources, but not what lies beside those, and opening thousands only to ask would take long.
    for (std::size_t i = 1, sources = files.size(); i < sources; ++i)
        for (const char* end : {".aux.xml", ".ovr", ".msk", ".prj", ".hdr", ".tfw", ".wld", ".aux", ".clr"}) {
            const std::string after = files[i] + end, instead = fs::path(files[i]).replace_extension(end).string();
            if (fs::exists(status_of(after))) files.push_back(after);
            if (fs::exists(status_of(instead))) files.push_back(instead);
        }
    for (int i = 0; i < listed.Count(); ++i) files.emplace_back(listed[i]);
    return files;
}

} // namespace fjell::baker
