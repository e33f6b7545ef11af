#include "baker/pack/join.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "fjell/io/pack_file.h"
#include "io/set_parts.h"

namespace fjell::baker {

namespace {

using io::Failure;
namespace fs = std::filesystem;

// A pack that is to be a member, closed again.
struct Member {
    std::string file;
    PackHeader header;
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
        members.push_back({name, io::PackFile((fs::path(folder) / name).string()).pack().header});
    }
    return members;
}

// Tiles from the whole's first one, west to east or north to south.
std::uint32_t tiles_from(double begin, const Member& member, const Member& first, int axis) {
    constexpr double most_apart = 1e-3; // cells; origins are far finer
    const PackHeader& h = member.header;
    const double step = h.crs_step[axis] > 0 ? h.crs_step[axis] : h.spacing_m[axis];
    const double side = std::ldexp(1.0, static_cast<int>(h.tile_log2));
    const double cells = std::abs(h.origin_m[axis] - begin) / step, tiles = std::round(cells / side);
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

// The index that packs at these origins have.
io::SetFile index_of(const std::vector<Member>& members) {
    const auto first_on = [&](int axis) -> const Member& { // the most western, or the most northern
        return *std::min_element(members.begin(), members.end(), [&](const Member& a, const Member& b) {
            return axis == 0 ? a.header.origin_m[0] < b.header.origin_m[0]
                             : a.header.origin_m[1] > b.header.origin_m[1];
        });
    };
    const Member &west = first_on(0), &north = first_on(1);
    const PackHeader& h = members.front().header;
    io::SetFile set{0, 0, 1u << h.tile_log2, {h.spacing_m[0], h.spacing_m[1]}, {}};
    for (const Member& member : members) {
        const PackHeader& p = member.header;
        const std::uint32_t x = tiles_from(west.header.origin_m[0], member, west, 0),
                            y = tiles_from(north.header.origin_m[1], member, north, 1);
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
