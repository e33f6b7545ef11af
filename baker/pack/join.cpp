#include "baker/pack/join.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "baker/read/tile_pages.h"
#include "fjell/io/failure.h"
#include "fjell/io/pack_file.h"
#include "io/set_parts.h"
#include "shared/terrain_data.h"

namespace fjell::baker {

namespace {

enum class Side { north, south, west, east };

// Of a tile, counted along one of its sides.
SampleIndex on_side(Side side, std::int32_t i, std::int32_t n) {
    switch (side) {
    case Side::north: return {i, 0};
    case Side::south: return {i, n};
    case Side::west: return {0, i};
    case Side::east: break;
    }
    return {n, i};
}

struct BorderVertex {
    std::int32_t steps = 0;
    bool hole = false;
    std::uint8_t error = 0, radius = 0; // codes; of a tile's corner none
    friend bool operator==(const BorderVertex&, const BorderVertex&) = default;
};

// A vertex on a side lies in one page of its tile, and what that page needs to be decoded are coarser pages along the
// same side.
std::vector<std::uint32_t> pages_along(const PageLayout& pages, Side side) {
    std::set<std::uint32_t> found;
    const auto n = static_cast<std::int32_t>(pages.side());
    for (std::int32_t i = 0; i <= n; ++i) {
        const SampleIndex c = on_side(side, i, n);
        found.insert(pages.place(static_cast<std::uint32_t>(c.column), static_cast<std::uint32_t>(c.row)).page);
    }
    return {found.begin(), found.end()};
}

// A pack of the set of which sides of tiles are read.
class BorderPack {
public:
    BorderPack(const std::string& path, const io::SetFilePack& place)
        : file_(path), pages_(pages_of(file_.pack().header)), sides_{pages_along(pages_, Side::north),
                                                                     pages_along(pages_, Side::south),
                                                                     pages_along(pages_, Side::west),
                                                                     pages_along(pages_, Side::east)},
          loaded_(file_, most_pages()), name_(place.file) {
        const PackHeader& h = file_.pack().header;
        if (h.tiles_x != place.tiles_x || h.tiles_y != place.tiles_y || file_.packs() != 1)
            throw io::Failure(1, path + ": has other tiles than the set says; write the set again");
    }
    [[nodiscard]] const PackHeader& header() const { return file_.pack().header; }
    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] const TerrainData& data() const { return data_of(loaded_.terrain()); }
    [[nodiscard]] std::uint64_t bytes_read() const { return bytes_read_; }

    [[nodiscard]] std::vector<BorderVertex> read(std::uint32_t tile_x, std::uint32_t tile_y, Side side) {
        const std::uint32_t tile = tile_y * header().tiles_x + tile_x;
        const std::vector<std::uint32_t>& pages = sides_[static_cast<std::size_t>(side)];
        for (const std::uint32_t page : pages)
            bytes_read_ += file_.pack().entry(chunk_index(header(), {ChunkKind::geometry, tile, page})).stored_bytes;
        loaded_.load_pages(tile, pages);
        const auto n = static_cast<std::int32_t>(pages_.side());
        std::vector<BorderVertex> vertices(static_cast<std::size_t>(n) + 1);
        for (std::int32_t i = 0; i <= n; ++i) {
            const SampleIndex c = on_side(side, i, n);
            const PagePlace at = pages_.place(static_cast<std::uint32_t>(c.column), static_cast<std::uint32_t>(c.row));
            const PageEntry page = data().page_table[std::size_t{tile} * data().pages_per_tile + at.page];
            const VertexRecord& record = data().records[std::size_t{page.slot} * data().page_capacity + at.index];
            const bool corner = i == 0 || i == n;
            vertices[static_cast<std::size_t>(i)] = {
                page.base + record.height, (record.radius & void_bit) != 0, corner ? std::uint8_t{0} : record.error,
                corner ? std::uint8_t{0} : static_cast<std::uint8_t>(record.radius & ~void_bit)};
        }
        return vertices;
    }

private:
    [[nodiscard]] std::uint32_t most_pages() const {
        std::size_t most = 0;
        for (const auto& side : sides_) most = std::max(most, side.size());
        return static_cast<std::uint32_t>(most);
    }

    const io::PackFile file_;
    const PageLayout pages_;
    const std::vector<std::uint32_t> sides_[4];
    TilePages loaded_;
    const std::string name_;
    std::uint64_t bytes_read_ = 0;
};

// Whether codes of both mean the same, so that bits can be compared.
bool comparable(const PackHeader& a, const PackHeader& b) {
    const auto same = [](const auto& x, const auto& y) { return !(x < y || y < x); };
    return a.tile_log2 == b.tile_log2 && same(a.base_m, b.base_m) && same(a.quantum_m, b.quantum_m) &&
           same(a.error_floor_m, b.error_floor_m) && same(a.error_ratio, b.error_ratio) &&
           std::equal(std::begin(a.level_radius_m), std::end(a.level_radius_m), b.level_radius_m, same);
}

// What a border's vertices have in two packs, and where they differ most.
struct Difference {
    std::uint64_t count = 0;
    double most_m = -1, here_m = 0, there_m = 0;
    SampleIndex at; // in samples of the first pack
    void add(SampleIndex place, double here, double there) {
        ++count;
        if (std::abs(here - there) <= most_m) return;
        most_m = std::abs(here - there);
        here_m = here, there_m = there, at = place;
    }
};

class Border {
public:
    // to_east: b lies east of a; otherwise south.
    Border(BorderPack& a, const io::SetFilePack& at_a, BorderPack& b, const io::SetFilePack& at_b, bool to_east)
        : a_(a), b_(b), at_a_(at_a), at_b_(at_b), to_east_(to_east) {}

    // Returns how many vertices they share.
    std::uint64_t compare() {
        const auto [begin_a, end_a] = span_of(at_a_);
        const auto [begin_b, end_b] = span_of(at_b_);
        const std::uint32_t begin = std::max(begin_a, begin_b), end = std::min(end_a, end_b);
        for (std::uint32_t tile = begin; tile < end; ++tile) {
            io::check_interrupt();
            compare_tiles(tile - begin_a, tile - begin_b, tile == begin);
        }
        return vertices_;
    }
    // Empty: they agree.
    [[nodiscard]] std::string difference() const {
        const auto line = [&](const Difference& d, const std::string& what, const std::string& values) {
            return fmt::format("{} and {}: {} of {} {} on their border differ, most at {}: {}; {}", a_.name(),
                               b_.name(), d.count, vertices_, what, place(d.at), values, remedy);
        };
        const auto metres = [](const Difference& d) {
            return fmt::format("{:.6g} m and {:.6g} m", d.here_m, d.there_m);
        };
        if (heights_.count != 0) return line(heights_, "heights", metres(heights_));
        if (holes_.count != 0) return line(holes_, "holes", "a hole in one of the two");
        if (errors_.count != 0) return line(errors_, "errors", metres(errors_) + ", where heights agree");
        if (radii_.count != 0) return line(radii_, "radii", metres(radii_) + ", where heights and errors agree");
        return {};
    }

private:
    static constexpr const char* remedy =
        "bake what both were baked from as one: fjell-bake plan IN... -o PLAN --shards N, then fjell-bake launch PLAN "
        "-o FOLDER --packs AxB";

    // Tiles along the border.
    [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> span_of(const io::SetFilePack& p) const {
        return to_east_ ? std::pair{p.tile_y, p.tile_y + p.tiles_y} : std::pair{p.tile_x, p.tile_x + p.tiles_x};
    }

    void compare_tiles(std::uint32_t in_a, std::uint32_t in_b, bool first) {
        const std::uint32_t last = (to_east_ ? at_a_.tiles_x : at_a_.tiles_y) - 1;
        const auto of_a = to_east_ ? a_.read(last, in_a, Side::east) : a_.read(in_a, last, Side::south);
        const auto of_b = to_east_ ? b_.read(0, in_b, Side::west) : b_.read(in_b, 0, Side::north);
        const auto n = static_cast<std::int32_t>(of_a.size()) - 1;
        const SampleIndex nw =
            to_east_ ? SampleIndex{static_cast<std::int32_t>(last) * n, static_cast<std::int32_t>(in_a) * n}
                     : SampleIndex{static_cast<std::int32_t>(in_a) * n, static_cast<std::int32_t>(last) * n};
        for (std::int32_t i = first ? 0 : 1; i <= n; ++i) { // the first of each further tile was the last one's last
            ++vertices_;
            const auto k = static_cast<std::size_t>(i);
            if (of_a[k] == of_b[k]) continue;
            compare_vertex(nw + on_side(to_east_ ? Side::east : Side::south, i, n), of_a[k], of_b[k]);
        }
    }

    void compare_vertex(SampleIndex v, const BorderVertex& a, const BorderVertex& b) {
        const TerrainData& t = a_.data();
        if (a.steps != b.steps)
            heights_.add(v, static_cast<double>(t.height_scale.height_m(a.steps)),
                         static_cast<double>(t.height_scale.height_m(b.steps)));
        if (a.hole != b.hole) holes_.add(v, 0, 0);
        if (a.error != b.error)
            errors_.add(v, static_cast<double>(t.errors.metres[a.error]),
                        static_cast<double>(t.errors.metres[b.error]));
        if (a.radius != b.radius) {
            const double unit_m = static_cast<double>(t.header.level_radius_m[t.tree.level(v)]);
            radii_.add(v, unit_m * static_cast<double>(t.radii.factor[a.radius]),
                       unit_m * static_cast<double>(t.radii.factor[b.radius]));
        }
    }

    // Of the whole, and where the packs say that it lies.
    [[nodiscard]] std::string place(SampleIndex v) const {
        const PackHeader& h = a_.header();
        const std::int64_t side = std::int64_t{1} << h.tile_log2;
        const SampleIndex s = a_.data().tree.sample(v);
        std::string text = fmt::format("sample ({}, {})", at_a_.tile_x * side + s.column, at_a_.tile_y * side + s.row);
        if (h.crs_bytes != 0)
            text += fmt::format(", at ({:.10g}, {:.10g})", h.crs_origin[0] + s.column * step(0),
                                h.crs_origin[1] - s.row * step(1));
        return text;
    }
    [[nodiscard]] double step(int axis) const {
        const PackHeader& h = a_.header();
        return h.crs_step[axis] > 0 ? h.crs_step[axis] : h.spacing_m[axis];
    }

    BorderPack &a_, &b_;
    const io::SetFilePack &at_a_, &at_b_;
    const bool to_east_;
    std::uint64_t vertices_ = 0;
    Difference heights_, holes_, errors_, radii_;
};

// Packs by the line that their western (or northern) side lies on, and by where on it they begin.
using ByLine = std::map<std::pair<std::uint32_t, std::uint32_t>, const io::SetFilePack*>;

// Those that begin on this line and have tiles in [begin, end) along it, which none of them shares.
template <typename Body>
void for_each_on(const ByLine& packs, std::uint32_t line, std::uint32_t begin, std::uint32_t end, bool to_east,
                 const Body& body) {
    auto next = packs.upper_bound({line, begin});
    if (next != packs.begin() && std::prev(next)->first.first == line) --next;
    for (; next != packs.end() && next->first.first == line && next->first.second < end; ++next) {
        const io::SetFilePack& p = *next->second;
        if (next->first.second + (to_east ? p.tiles_y : p.tiles_x) > begin) body(p);
    }
}

} // namespace

BorderReport compare_borders(const io::SetFile& set, const std::string& folder) {
    ByLine western, northern;
    for (const io::SetFilePack& p : set.packs) {
        western[{p.tile_x, p.tile_y}] = &p;
        northern[{p.tile_y, p.tile_x}] = &p;
    }
    const auto path_of = [&](const io::SetFilePack& p) { return (std::filesystem::path(folder) / p.file).string(); };
    BorderReport report;
    for (const io::SetFilePack& at_a : set.packs) {
        std::vector<std::pair<const io::SetFilePack*, bool>> beside;
        for_each_on(western, at_a.tile_x + at_a.tiles_x, at_a.tile_y, at_a.tile_y + at_a.tiles_y, true,
                    [&](const io::SetFilePack& p) { beside.emplace_back(&p, true); });
        for_each_on(northern, at_a.tile_y + at_a.tiles_y, at_a.tile_x, at_a.tile_x + at_a.tiles_x, false,
                    [&](const io::SetFilePack& p) { beside.emplace_back(&p, false); });
        if (beside.empty()) continue;
        BorderPack a(path_of(at_a), at_a);
        for (const auto& [at_b, to_east] : beside) {
            BorderPack b(path_of(*at_b), *at_b);
            if (!comparable(a.header(), b.header())) continue;
            Border border(a, at_a, b, *at_b, to_east);
            ++report.borders;
            report.vertices += border.compare();
            report.bytes_read += b.bytes_read();
            const std::string difference = border.difference();
            if (difference.empty()) continue;
            if (report.differing++ == 0) report.first = difference;
        }
        report.bytes_read += a.bytes_read();
    }
    if (report.differing == 2) report.first += " (one more border differs)";
    if (report.differing > 2) report.first += fmt::format(" ({} more borders differ)", report.differing - 1);
    return report;
}

namespace {

using io::Failure;
namespace fs = std::filesystem;

// A pack that is to be a member, closed again.
struct Member {
    std::string file;
    PackHeader header;
    std::string crs; // WKT
};

std::vector<Member> members_in(const std::string& folder) {
    std::vector<std::string> names;
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
        std::error_code none;
        if (entry->path().extension() == ".fjell" && !entry->is_directory(none))
            names.push_back(entry->path().filename().string());
    }
    if (error)
        throw Failure(1, fmt::format("{}: cannot be listed ({}); give a folder of packs", folder, error.message()));
    if (names.empty()) throw Failure(1, folder + ": has no packs (*.fjell); bake them into it first");
    std::sort(names.begin(), names.end());
    std::vector<Member> members;
    for (const std::string& name : names) {
        io::check_interrupt();
        if (std::any_of(name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }))
            throw Failure(1, folder + ": has a pack whose name is no line of text; rename it"); // set.json refuses it
        const io::PackFile pack((fs::path(folder) / name).string());
        members.push_back({name, pack.pack().header, pack.crs()});
    }
    return members;
}

// Tiles from the whole's first one, west to east or north to south.
std::uint32_t tiles_from(double begin, const Member& member, const Member& first, int axis) {
    constexpr double most_apart = 1e-3; // cells; origins are far finer
    const PackHeader& h = member.header;
    const double step = h.crs_step[axis] > 0 ? h.crs_step[axis] : h.spacing_m[axis];
    const double side = std::ldexp(1.0, static_cast<int>(h.tile_log2));
    const double cells = std::abs(h.crs_origin[axis] - begin) / step, tiles = std::round(cells / side);
    if (!(tiles < max_columns))
        throw Failure(1, fmt::format("{}: lies {:.6g} tiles from {}, too far for one set; leave it out", member.file,
                                     tiles, first.file));
    if (!(std::abs(cells - tiles * side) < most_apart))
        throw Failure(1, fmt::format("{} and {}: lie {:.6g} tiles apart from {} to {}; packs of a set begin at whole "
                                     "tiles of {} cells: cut their height fields there, each with the next one's first "
                                     "column and row",
                                     first.file, member.file, (cells / side), axis == 0 ? "west" : "north",
                                     axis == 0 ? "east" : "south", side));
    return static_cast<std::uint32_t>(tiles);
}

// Degrees on both sides of the antimeridian become two zones of UTM, or begin a turn apart.
void refuse_other_places(const std::vector<Member>& members) {
    constexpr const char* remedy = "bake their height fields as one (fjell-bake WEST EAST -o ONE.fjell), then "
                                   "fjell-bake split ONE.fjell -o FOLDER";
    const Member& first = members.front();
    const auto name = [](const std::string& wkt) {
        const std::size_t from = wkt.find('"');
        return from == std::string::npos ? std::string("none")
                                         : wkt.substr(from + 1, wkt.find('"', from + 1) - from - 1);
    };
    for (const Member& member : members) {
        if (member.crs != first.crs)
            throw Failure(1, fmt::format("{} and {}: are in different CRSs, {} and {}; {}", first.file, member.file,
                                         name(first.crs), name(member.crs), remedy));
        if (first.crs.starts_with("GEOGC") && std::abs(member.header.crs_origin[0] - first.header.crs_origin[0]) > 180)
            throw Failure(1, fmt::format("{} and {}: lie in degrees on both sides of the antimeridian; {}", first.file,
                                         member.file, remedy));
    }
}

// The index that packs at these origins have.
io::SetFile index_of(const std::vector<Member>& members) {
    const auto first_on = [&](int axis) -> const Member& { // the most western, or the most northern
        return *std::min_element(members.begin(), members.end(), [&](const Member& a, const Member& b) {
            return axis == 0 ? a.header.crs_origin[0] < b.header.crs_origin[0]
                             : a.header.crs_origin[1] > b.header.crs_origin[1];
        });
    };
    const Member &west = first_on(0), &north = first_on(1);
    const PackHeader& h = members.front().header;
    io::SetFile set{0, 0, 1u << h.tile_log2, {h.spacing_m[0], h.spacing_m[1]}, {}};
    for (const Member& member : members) {
        const PackHeader& p = member.header;
        const std::uint32_t x = tiles_from(west.header.crs_origin[0], member, west, 0),
                            y = tiles_from(north.header.crs_origin[1], member, north, 1);
        const auto ends = [&](std::uint32_t tile, std::uint32_t samples) {
            const std::uint64_t end = (std::uint64_t{tile} << p.tile_log2) + samples;
            if (end > max_columns)
                throw Failure(1, fmt::format("{}: ends at sample {} of the set, which may have {} a side; leave it out",
                                             member.file, end, max_columns));
            return static_cast<std::uint32_t>(end);
        };
        set.columns = std::max(set.columns, ends(x, p.columns));
        set.rows = std::max(set.rows, ends(y, p.rows));
        set.packs.push_back({member.file, x, y, p.tiles_x, p.tiles_y, p.directory_hash, true});
    }
    std::sort(set.packs.begin(), set.packs.end(), [](const io::SetFilePack& a, const io::SetFilePack& b) {
        return std::pair{a.tile_y, a.tile_x} < std::pair{b.tile_y, b.tile_x};
    });
    return set;
}

void refuse_overlaps(const io::SetFile& set) {
    const std::size_t across = (set.columns - 2) / set.tile_cells + std::size_t{1},
                      down = (set.rows - 2) / set.tile_cells + std::size_t{1};
    if (across * down > max_sparse_tiles) return; // which opening refuses
    std::vector<const io::SetFilePack*> at(across * down, nullptr);
    for (const io::SetFilePack& pack : set.packs)
        for (std::size_t y = pack.tile_y; y < std::min(std::size_t{pack.tile_y} + pack.tiles_y, down); ++y)
            for (std::size_t x = pack.tile_x; x < std::min(std::size_t{pack.tile_x} + pack.tiles_x, across); ++x) {
                const io::SetFilePack*& holder = at[y * across + x];
                if (holder != nullptr)
                    throw Failure(1,
                                  fmt::format("{} and {}: both have tile ({}, {}) of the set; leave one out, or bake "
                                              "height fields that say where they lie",
                                              holder->file, pack.file, x, y));
                holder = &pack;
            }
}

} // namespace

JoinSummary join_packs(const std::string& folder) {
    const std::vector<Member> members = members_in(folder);
    refuse_other_places(members);
    const io::SetFile set = index_of(members);
    refuse_overlaps(set);
    JoinSummary summary;
    summary.borders = compare_borders(set, folder);
    if (!summary.borders.ok()) throw Failure(1, (fs::path(folder) / summary.borders.first).string());
    const std::string index = (fs::path(folder) / "set.json").string();
    (void)io::SetParts(set, index); // whatever else nobody would open
    write_set_index(set, index);
    summary.set.packs = static_cast<std::uint32_t>(set.packs.size());
    for (const Member& member : members) summary.set.file_bytes += member.header.file_bytes;
    return summary;
}

} // namespace fjell::baker
