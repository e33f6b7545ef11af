// From "The NetCDF Classic Format Specification" (Unidata): numrecs, dimensions, attributes, variables, big-endian.
#include "baker/read/netcdf_length.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <vector>

namespace fjell::baker {

namespace {

constexpr std::uint64_t sane = std::uint64_t{1} << 48; // keeps products of hostile numbers inside 64 bits

class Header {
public:
    explicit Header(const std::string& path) : file_(path, std::ios::binary) {
        std::array<char, 4> magic{};
        file_.read(magic.data(), magic.size());
        version_ = static_cast<unsigned char>(magic[3]);
        good_ = file_ && magic[0] == 'C' && magic[1] == 'D' && magic[2] == 'F' &&
                (version_ == 1 || version_ == 2 || version_ == 5);
    }
    [[nodiscard]] bool good() const { return good_; }
    [[nodiscard]] int version() const { return version_; }

    std::uint64_t number(int bytes) {
        std::uint64_t value = 0;
        for (int i = 0; i < bytes && good_; ++i) {
            const int byte = file_.get();
            good_ = byte != std::char_traits<char>::eof();
            value = value << 8 | static_cast<std::uint64_t>(byte & 0xff);
        }
        return value;
    }
    // Counts and lengths: 64 bits from CDF-5 on.
    std::uint64_t count() {
        const std::uint64_t value = number(version_ == 5 ? 8 : 4);
        if (value >= sane) good_ = false;
        return value;
    }
    void skip_padded(std::uint64_t bytes) {
        file_.seekg(static_cast<std::streamoff>((bytes + 3) / 4 * 4), std::ios::cur);
        good_ = good_ && file_.good();
    }
    void skip_name() { skip_padded(count()); }

private:
    std::ifstream file_;
    int version_ = 0;
    bool good_ = false;
};

std::uint64_t type_bytes(std::uint64_t type) {
    constexpr std::array<std::uint64_t, 12> bytes{0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};
    return type < bytes.size() ? bytes[type] : 0;
}

void skip_attributes(Header& header) {
    header.number(4);
    for (std::uint64_t left = header.count(); left > 0 && header.good(); --left) {
        header.skip_name();
        const std::uint64_t bytes = type_bytes(header.number(4));
        header.skip_padded(header.count() * bytes);
    }
}

struct Variable {
    std::uint64_t bytes = 0, begin = 0; // of one record, when it has records
    bool records = false;
};

Variable read_variable(Header& header, const std::vector<std::uint64_t>& dimensions) {
    Variable v;
    header.skip_name();
    std::uint64_t values = 1;
    const std::uint64_t rank = header.count();
    for (std::uint64_t i = 0; i < rank && header.good(); ++i) {
        const std::uint64_t id = header.count();
        const std::uint64_t length = id < dimensions.size() ? dimensions[id] : 1;
        if (length == 0 && i == 0)
            v.records = true;
        else
            values = length > 0 && values > sane / length ? sane : values * length;
    }
    skip_attributes(header);
    v.bytes = std::min(values * type_bytes(header.number(4)), sane);
    header.count(); // vsize: redundant, and wrong beyond 4 GB
    v.begin = std::min(header.number(header.version() == 1 ? 4 : 8), sane);
    return v;
}

std::uint64_t end_of(const std::vector<Variable>& variables, std::uint64_t records) {
    std::uint64_t record_bytes = 0, kinds = 0, end = 0;
    for (const Variable& v : variables)
        if (v.records) record_bytes = std::min(record_bytes + (v.bytes + 3) / 4 * 4, sane), ++kinds;
    for (const Variable& v : variables) {
        if (!v.records) end = std::max(end, v.begin + v.bytes);
        // A lone record variable is not padded.
        const std::uint64_t stride = kinds == 1 ? v.bytes : record_bytes;
        if (!v.records || records == 0 || records >= 0xffffffff) continue;
        const std::uint64_t before = stride > sane / records ? sane : (records - 1) * stride;
        end = std::max(end, v.begin + before + v.bytes);
    }
    return end;
}

} // namespace

std::optional<std::uint64_t> netcdf_length(const std::string& path) {
    Header header(path);
    if (!header.good()) return std::nullopt;
    const std::uint64_t records = header.number(header.version() == 5 ? 8 : 4);
    std::vector<std::uint64_t> dimensions;
    header.number(4);
    for (std::uint64_t left = header.count(); left > 0 && header.good(); --left) {
        header.skip_name();
        dimensions.push_back(header.count());
    }
    skip_attributes(header);
    std::vector<Variable> variables;
    header.number(4);
    for (std::uint64_t left = header.count(); left > 0 && header.good(); --left)
        variables.push_back(read_variable(header, dimensions));
    return header.good() ? end_of(variables, records) : netcdf_damaged;
}

} // namespace fjell::baker
