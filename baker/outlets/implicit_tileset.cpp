#include "baker/outlets/implicit_tileset.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace fjell::baker {

namespace {

using nlohmann::ordered_json;

constexpr int subtree_levels = 5; // 341 tiles, and 8 KB of what they say

std::string root_folder(TileId root) {
    return fmt::format("{}-{}-{}", root.level, root.x, root.y);
}
TileId ancestor_at(std::int32_t level, TileId t) {
    const int up = t.level - level;
    return {level, t.x >> up, t.y >> up};
}

// Bits in the order of their numbers, the lowest of a byte first.
struct TileBits {
    explicit TileBits(std::size_t size) : bytes((size + 7) / 8) {}
    void set(std::size_t at) {
        bytes[at / 8] |= std::byte{1} << at % 8;
        ++count;
    }
    std::vector<std::byte> bytes;
    std::size_t count = 0;
};

// The binary part of a subtree; views begin at multiples of 8.
struct SubtreeBuffer {
    std::size_t add(std::span<const std::byte> some) {
        views.push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", some.size()}});
        bytes.insert(bytes.end(), some.begin(), some.end());
        bytes.resize((bytes.size() + 7) / 8 * 8);
        return views.size() - 1;
    }
    std::vector<std::byte> bytes;
    ordered_json views = ordered_json::array();
};

// A tile among those of its level below a subtree's root: by turns a bit of its column and of its row.
struct Below {
    std::size_t tile; // in its level
    std::size_t morton;
};
std::vector<Below> next_level(const std::vector<Below>& above, const std::vector<TilesetTile>& tiles,
                              const std::vector<TilesetTile>& below) {
    std::vector<Below> next;
    for (const Below& b : above)
        for (int child = 0; child < 4; ++child) {
            const std::size_t at = find_tile(below, child_of(tiles[b.tile].id, child));
            if (at < below.size()) next.push_back({at, 4 * b.morton + static_cast<std::size_t>(child)});
        }
    return next;
}

template <typename Value>
std::size_t add_column(SubtreeBuffer& buffer, const std::vector<TilesetTile>& rows, const Value& value) {
    std::vector<double> column;
    for (const TilesetTile& t : rows) column.push_back(value(t));
    return buffer.add(std::as_bytes(std::span(column)));
}

// Magic, version, the lengths of JSON and of what follows it, in multiples of 8.
std::vector<std::byte> subtree_file(std::string json, const std::vector<std::byte>& binary) {
    json.resize((json.size() + 7) / 8 * 8, ' ');
    std::vector<std::byte> file;
    const auto put = [&](std::span<const std::byte> some) { file.insert(file.end(), some.begin(), some.end()); };
    const std::uint32_t head[2] = {0x74627573, 1};
    const std::uint64_t lengths[2] = {json.size(), binary.size()};
    put(std::as_bytes(std::span(head)));
    put(std::as_bytes(std::span(lengths)));
    put(std::as_bytes(std::span(json)));
    put(binary);
    return file;
}

// first: of the tiles of `level` the one that it begins with.
std::vector<std::byte> subtree(const TilesetLevels& levels, std::size_t level, std::size_t first) {
    constexpr std::size_t all = ((std::size_t{1} << 2 * subtree_levels) - 1) / 3, children = all * 3 + 1;
    TileBits there(all), next(children);
    std::vector<TilesetTile> rows;
    std::vector<Below> tiles{{first, 0}};
    std::size_t before = 0; // bits of coarser levels
    for (std::size_t k = 0; k < subtree_levels && !tiles.empty(); ++k) {
        const std::vector<TilesetTile>& here = levels[level + k];
        for (const Below& b : tiles) there.set(before + b.morton), rows.push_back(here[b.tile]);
        before = 4 * before + 1;
        tiles = level + k + 1 < levels.size() ? next_level(tiles, here, levels[level + k + 1]) : std::vector<Below>{};
    }
    for (const Below& b : tiles) next.set(b.morton);

    SubtreeBuffer buffer;
    const ordered_json available{{"bitstream", buffer.add(there.bytes)}, {"availableCount", there.count}};
    ordered_json below{{"constant", 0}};
    if (next.count > 0) below = {{"bitstream", buffer.add(next.bytes)}, {"availableCount", next.count}};
    const ordered_json columns{
        {"error", {{"values", add_column(buffer, rows, [](const TilesetTile& t) { return t.error_m; })}}},
        {"low", {{"values", add_column(buffer, rows, [](const TilesetTile& t) { return t.low_m; })}}},
        {"high", {{"values", add_column(buffer, rows, [](const TilesetTile& t) { return t.high_m; })}}}};
    const ordered_json json{
        {"buffers", ordered_json::array({{{"byteLength", buffer.bytes.size()}}})},
        {"bufferViews", buffer.views},
        {"propertyTables", ordered_json::array({{{"class", "tile"}, {"count", rows.size()}, {"properties", columns}}})},
        {"tileAvailability", available},
        {"contentAvailability", ordered_json::array({available})},
        {"childSubtreeAvailability", below},
        {"tileMetadata", 0}};
    return subtree_file(json.dump(), buffer.bytes);
}

ordered_json schema() {
    const auto number = [](const char* semantic) {
        return ordered_json{
            {"type", "SCALAR"}, {"componentType", "FLOAT64"}, {"semantic", semantic}, {"required", true}};
    };
    return {{"id", "fjell"},
            {"classes",
             {{"tile",
               {{"properties",
                 {{"error", number("TILE_GEOMETRIC_ERROR")},
                  {"low", number("TILE_MINIMUM_HEIGHT")},
                  {"high", number("TILE_MAXIMUM_HEIGHT")}}}}}}}};
}

} // namespace

std::string implicit_path(TileId id, std::int32_t first_level, const char* ending) {
    const TileId root = ancestor_at(first_level, id);
    const int down = id.level - first_level;
    return fmt::format("{}/{}/{}/{}{}", root_folder(root), down, id.x - (root.x << down), id.y - (root.y << down),
                       ending);
}

void write_implicit_tileset(TilesetLevels made, const std::string& extras, const TakeFile& take) {
    const TilesetLevels levels = with_children(std::move(made));
    const std::int32_t first_level = levels.front().front().id.level;
    for (std::size_t level = 0; level < levels.size(); level += subtree_levels)
        for (std::size_t i = 0; i < levels[level].size(); ++i)
            take(implicit_path(levels[level][i].id, first_level, ".subtree"), subtree(levels, level, i));

    ordered_json children = ordered_json::array();
    for (const TilesetTile& root : levels.front()) {
        double error_m = 0;
        std::size_t deep = 0;
        for (std::size_t level = 0; level < levels.size(); ++level)
            for (const TilesetTile& t : levels[level])
                if (ancestor_at(first_level, t.id) == root.id) {
                    error_m = std::max(error_m, std::ldexp(t.error_m, static_cast<int>(level)));
                    deep = level + 1;
                }
        const std::string uri = root_folder(root.id) + "/{level}/{x}/{y}";
        children.push_back({{"boundingVolume",
                             {{"region", region_json(box_of(Tiling::geographic, root.id), root.low_m, root.high_m)}}},
                            {"geometricError", error_m},
                            {"refine", "REPLACE"},
                            {"content", {{"uri", uri + ".glb"}}},
                            {"implicitTiling",
                             {{"subdivisionScheme", "QUADTREE"},
                              {"subtreeLevels", subtree_levels},
                              {"availableLevels", deep},
                              {"subtrees", {{"uri", uri + ".subtree"}}}}}});
    }
    ordered_json tileset = tileset_of(Tiling::geographic, levels.front(), std::move(children), extras);
    tileset["schema"] = schema();
    const std::string text = tileset.dump() + "\n";
    take("tileset.json", std::as_bytes(std::span(text)));
}

} // namespace fjell::baker
