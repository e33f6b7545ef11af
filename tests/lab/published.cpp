#include "lab/published.h"

#include <nlohmann/json.hpp>

#include "fjell/io/failure.h"
#include "io/file.h"
#include "io/json.h"

namespace fjell::lab {

std::vector<Published> read_published(const std::string& file, const std::vector<std::string>& names) {
    std::vector<Published> found;
    if (names.empty()) return found;
    const nlohmann::json root = io::parse_json(io::read_text(file), file, io::JsonComments::yes);
    for (const std::string& name : names) {
        const std::size_t before = found.size();
        try {
            for (const nlohmann::json& each : root.at("series"))
                if (each.at("name") == name)
                    found.push_back({name, each.at("where").get<std::string>(),
                                     each.at("thresholds_px").get<std::vector<double>>(),
                                     each.at("frames_a_second").get<std::vector<double>>(),
                                     each.at("vertices").get<std::vector<double>>()});
        } catch (const nlohmann::json::exception&) {
            throw io::Failure(1, file + ": " + name + ": is no series; give name, where, and three lists of numbers");
        }
        if (found.size() == before) throw io::Failure(1, file + ": " + name + ": there is no such series; add it");
        const Published& p = found.back();
        if (p.vertices.size() != p.thresholds_px.size() || p.frames_a_second.size() != p.thresholds_px.size())
            throw io::Failure(1, file + ": " + name + ": its lists must be of one length");
    }
    return found;
}

} // namespace fjell::lab
