#include "baker/outlets/tiles.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <numbers>
#include <span>
#include <type_traits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/georeference/crs_label.h"
#include "baker/outlets/implicit_tileset.h"
#include "baker/outlets/pack_map.h"
#include "baker/outlets/quantized_mesh.h"
#include "baker/outlets/raster_tiles.h"
#include "baker/outlets/surface.h"
#include "baker/outlets/tile_archive.h"
#include "baker/outlets/tile_mesh.h"
#include "baker/outlets/tileset.h"
#include "baker/store/parallel.h"
#include "gltf/glb.h"
#include "io/file.h"

namespace fjell::baker {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

// What is remembered of a tile that is written.
struct Made {
    double error_m = 0, low_m = 0, high_m = 0;
    std::uint64_t vertices = 0, triangles = 0, bytes = 0; // 0 vertices: it is not made yet
    std::uint64_t above = 0;                              // 1: its mesh does not keep the tolerance
};
struct Tile {
    TileId id;
    Made made;
    BorderVertices borders;
};

// The tiles of one level that are made, a record each, in the order in which they were. The last record of a tile is
// the one that counts; one that is cut short was not written.
class Journal {
public:
    explicit Journal(const std::string& path) : path_(path) {}

    template <typename Take>
    void read(const Take& take) const {
        std::ifstream file(path_, std::ios::binary);
        while (file) {
            Tile tile;
            std::array<std::uint16_t, 4> counts{};
            get(file, tile.id), get(file, tile.made), get(file, counts);
            for (std::size_t side = 0; side < 4; ++side) {
                tile.borders[side].resize(counts[side]);
                file.read(reinterpret_cast<char*>(tile.borders[side].data()),
                          static_cast<std::streamsize>(counts[side] * sizeof(std::uint16_t)));
            }
            if (file) take(tile);
        }
    }
    // What read() has given, and nothing after it.
    void begin(const std::vector<Tile>& tiles) {
        file_.open(path_ + ".new", std::ios::binary | std::ios::trunc);
        for (const Tile& tile : tiles)
            if (tile.made.vertices != 0) add(tile);
        std::error_code error;
        fs::rename(path_ + ".new", path_, error);
        if (error) io::disk_failure(path_, "write");
    }
    void add(const Tile& tile) {
        std::array<std::uint16_t, 4> counts{};
        for (std::size_t side = 0; side < 4; ++side)
            counts[side] = static_cast<std::uint16_t>(tile.borders[side].size());
        put(tile.id), put(tile.made), put(counts);
        for (const auto& border : tile.borders)
            file_.write(reinterpret_cast<const char*>(border.data()),
                        static_cast<std::streamsize>(border.size() * sizeof(std::uint16_t)));
        if (!file_.flush()) io::disk_failure(path_, "write");
    }

private:
    template <typename T>
    static void get(std::ifstream& file, T& value) {
        file.read(reinterpret_cast<char*>(&value), sizeof value);
    }
    template <typename T>
    void put(const T& value) {
        file_.write(reinterpret_cast<const char*>(&value), sizeof value);
    }
    std::string path_;
    std::ofstream file_;
};

// What one thread works with at a time.
struct Tools {
    Tools(const HeightSource& source, const TilesOptions& options) : finder(source) {
        if (options.colours) colours.emplace(options.maps_of, PackMap::Kind::colour);
        if (options.water) water.emplace(options.maps_of, PackMap::Kind::water);
    }
    SampleFinder finder;
    std::optional<PackMap> colours, water;
};

// One for each thread, handed out and taken back.
class Toolbox {
public:
    Toolbox(const HeightSource& source, const TilesOptions& options) : source_(source), options_(options) {}
    template <typename Use>
    void lend(const Use& use) {
        std::unique_ptr<Tools> tools;
        {
            const std::lock_guard hold(lock_);
            if (!free_.empty()) tools = std::move(free_.back()), free_.pop_back();
        }
        if (!tools) tools = std::make_unique<Tools>(source_, options_);
        use(*tools);
        const std::lock_guard hold(lock_);
        free_.push_back(std::move(tools));
    }

private:
    const HeightSource& source_;
    const TilesOptions& options_;
    std::mutex lock_;
    std::vector<std::unique_ptr<Tools>> free_;
};

double power_of_two_below(double value) {
    return std::exp2(std::floor(std::log2(value)));
}

// At the equator.
double tile_m(Tiling tiling, int level) {
    return 2 * std::numbers::pi * globe_radius_m / tiles_across(tiling, level);
}

int last_level(const HeightSource& source, const std::string& name, const TilesOptions& options, Tiling tiling) {
    constexpr double share = 5, fewest_samples = 8;
    const double spacing_m = std::min(source.spacing_m[0], source.spacing_m[1]);
    int most = 0;
    while (most < most_tile_level && tile_m(tiling, most + 1) >= fewest_samples * spacing_m) ++most;
    if (options.max_level > most)
        throw Failure(1,
                      fmt::format("{}: its samples are {} m apart, so that level {} shows nothing more than {}; give "
                                  "--max-level {}",
                                  name, spacing_m, options.max_level, most, most));
    if (options.max_level >= 0) return options.max_level;
    const auto is_fine = [&](int level) {
        return is_raster(options.format) ? tile_m(tiling, level) / options.side_px <= spacing_m
                                         : assumed_error_m(tiling, level) <= spacing_m / share;
    };
    int level = 0;
    while (level < most && !is_fine(level)) ++level;
    return level;
}

class Pyramid {
public:
    Pyramid(const GroundSurface& surface, const std::string& name, const TilesOptions& options, Tiling tiling,
            const std::string& folder, const std::string& work)
        : surface_(surface), name_(name), options_(options), tiling_(tiling), folder_(folder), work_(work),
          threads_(resolve_threads(options.threads)), toolbox_(surface.source(), options) {}

    TilesSummary write(int last) {
        last_ = last;
        TilesSummary summary;
        std::vector<TileId> ids;
        for (std::int32_t x = 0; x < tiles_across(tiling_, 0); ++x) ids.push_back({0, x, 0});
        std::vector<std::vector<TileId>> levels;
        for (int level = 0; level <= last; ++level) {
            if (level > 0) ids = children_with_ground(ids);
            // Of a tileset the coarsest level is no larger than the ground makes it.
            constexpr std::size_t few = 4;
            if (is_tileset() && ids.size() <= few) levels.clear();
            levels.push_back(ids);
        }
        for (const std::vector<TileId>& level : levels) available_.push_back(runs(level));
        first_ = levels.front().front().level;
        TilesetLevels made;
        for (const std::vector<TileId>& level : levels) {
            std::vector<Tile> tiles;
            summary.levels.push_back(write_level(level.front().level, level, tiles));
            made.emplace_back();
            if (is_tileset())
                for (const Tile& t : tiles) made.back().push_back({t.id, t.made.error_m, t.made.low_m, t.made.high_m});
        }
        bounds_ = bounds(levels.back());
        if (!is_tileset())
            write_text(is_raster() ? "tiles.json" : "layer.json", index(summary));
        else if (options_.implicit_tree)
            write_implicit_tileset(std::move(made), about(summary).dump(),
                                   [&](const std::string& file, std::span<const std::byte> bytes) {
                                       io::check_interrupt();
                                       write_file(file, bytes);
                                   });
        else
            write_text("tileset.json", tileset_json(tiling_, std::move(made), about(summary).dump()));
        for (const std::vector<TileId>& level : levels)
            for (const TileId& id : level) written_.push_back({id, path_of(id)});
        return summary;
    }
    // After write().
    void archive(Archive kind, const TilesSummary& summary, const std::string& path) const {
        write_archive(kind, written_,
                      {fs::path(name_).stem().string(), is_raster() ? picture_ending() + 1 : "quantized-mesh-1.0",
                       !is_raster() && options_.gzip, bounds_, index(summary)},
                      path, work_);
    }

private:
    [[nodiscard]] bool is_tileset() const { return options_.format == TilesFormat::tiles_3d; }
    [[nodiscard]] bool is_raster() const { return baker::is_raster(options_.format); }
    [[nodiscard]] const char* picture_ending() const { return options_.webp ? ".webp" : ".png"; }
    [[nodiscard]] std::string path_of(TileId id) const {
        if (options_.implicit_tree) return folder_ + "/" + implicit_path(id, first_, ".glb");
        return fmt::format("{}/{}/{}/{}{}", folder_, id.level, id.x,
                           is_raster() ? tiles_down(id.level) - 1 - id.y : id.y,
                           is_raster()    ? picture_ending()
                           : is_tileset() ? ".glb"
                                          : ".terrain");
    }
    [[nodiscard]] std::vector<TileId> children_with_ground(const std::vector<TileId>& parents) const {
        std::vector<std::uint8_t> there(parents.size() * 4);
        const auto child = [&](std::size_t i) { return child_of(parents[i / 4], static_cast<int>(i % 4)); };
        parallel_for(static_cast<std::int64_t>(there.size()), threads_, [&](std::int64_t i) {
            const auto at = static_cast<std::size_t>(i);
            there[at] = surface_.touches(box_of(tiling_, child(at)));
        });
        std::vector<TileId> ids;
        for (std::size_t i = 0; i < there.size(); ++i)
            if (there[i]) ids.push_back(child(i));
        std::sort(ids.begin(), ids.end(),
                  [](const TileId& a, const TileId& b) { return a.y != b.y ? a.y < b.y : a.x < b.x; });
        return ids;
    }

    // With height 0, which lies around.
    [[nodiscard]] double relief_m() const {
        const HeightRange range = surface_.range();
        return std::max(0.0, static_cast<double>(range.high)) - std::min(0.0, static_cast<double>(range.low));
    }

    [[nodiscard]] TileRules rules_of(int level) const {
        const double assumed_m = assumed_error_m(tiling_, level);
        constexpr double share = 1.0 / 16, finest_m = 1.0 / 4096, room = 32000;
        const double step_m = std::clamp(2 * power_of_two_below(relief_m() / room + finest_m), finest_m,
                                         std::max(finest_m, power_of_two_below(assumed_m * share)));
        // A flat triangle of this grid's cells lies at most a quarter of the error below the globe.
        const double cells = tile_m(tiling_, level) * tile_m(tiling_, level) / (globe_radius_m * assumed_m);
        return {assumed_m, step_m, std::max(1, static_cast<int>(std::ceil(std::log2(cells) / 2)))};
    }

    using Places = std::map<std::pair<std::int32_t, std::int32_t>, std::size_t>; // x, y
    static constexpr std::size_t nobody = ~std::size_t{0};
    [[nodiscard]] std::size_t neighbour(const Places& places, TileId id, std::size_t side) const {
        const std::int32_t across = tiles_across(tiling_, id.level);
        constexpr std::int32_t dx[4] = {-1, 0, 1, 0}, dy[4] = {0, -1, 0, 1};
        const auto found = places.find({(id.x + dx[side] + across) % across, id.y + dy[side]});
        return found == places.end() ? nobody : found->second;
    }

    // Of a neighbour's vertices some are missing here, or nothing is here.
    [[nodiscard]] bool is_due(const std::vector<Tile>& tiles, const Places& places, std::size_t i) const {
        if (tiles[i].made.vertices == 0) return true;
        for (std::size_t side = 0; side < 4; ++side) {
            const std::size_t other = neighbour(places, tiles[i].id, side);
            if (other == nobody) continue;
            const auto &mine = tiles[i].borders[side], &theirs = tiles[other].borders[opposite(side)];
            if (!std::includes(mine.begin(), mine.end(), theirs.begin(), theirs.end())) return true;
        }
        return false;
    }

    LevelSummary write_level(int level, const std::vector<TileId>& ids, std::vector<Tile>& tiles) {
        Places places;
        for (const TileId& id : ids) {
            places[{id.x, id.y}] = tiles.size();
            tiles.push_back({id, {}, {}});
        }
        Journal journal(fmt::format("{}/level-{}", work_, level));
        journal.read([&](const Tile& made) {
            const auto at = places.find({made.id.x, made.id.y});
            if (at != places.end() && made.id.level == level) tiles[at->second] = made;
        });
        journal.begin(tiles);
        const TileRules rules = rules_of(level);
        // Every second tile like a chessboard's: none of a pass is another's neighbour, but for a globe of one tile.
        for (bool any = true; any;) {
            any = false;
            for (const std::int32_t colour : {0, 1}) {
                std::vector<std::size_t> due;
                for (std::size_t i = 0; i < tiles.size(); ++i)
                    if (((tiles[i].id.x + tiles[i].id.y) & 1) == colour && is_due(tiles, places, i)) due.push_back(i);
                any = any || !due.empty();
                make(level, rules, tiles, places, due, journal);
            }
        }
        return summary_of(level, is_raster() ? 0 : rules.tolerance_m, tiles);
    }

    void make(int level, const TileRules& rules, std::vector<Tile>& tiles, const Places& places,
              const std::vector<std::size_t>& due, Journal& journal) {
        const std::string stage = fmt::format("level {}", level);
        std::mutex lock;
        std::uint64_t done = 0;
        parallel_for(static_cast<std::int64_t>(due.size()), threads_, [&](std::int64_t i) {
            Tile& tile = tiles[due[static_cast<std::size_t>(i)]];
            BorderVertices wanted;
            for (std::size_t side = 0; side < 4; ++side) {
                const std::size_t other = neighbour(places, tile.id, side);
                if (other != nobody) wanted[side] = tiles[other].borders[opposite(side)];
            }
            toolbox_.lend([&](Tools& tools) { write_tile(rules, tools, wanted, tile); });
            const std::lock_guard hold(lock);
            journal.add(tile);
            if (options_.progress) options_.progress(stage.c_str(), ++done, due.size());
        });
    }

    void write_tile(const TileRules& rules, Tools& tools, const BorderVertices& wanted, Tile& tile) {
        const std::vector<std::byte> bytes =
            is_raster() ? picture(tools.finder, tile) : meshed(rules, tools, wanted, tile);
        const std::string path = path_of(tile.id), folder = fs::path(path).parent_path().string();
        std::error_code error;
        fs::create_directories(folder, error);
        if (error) errno = error.value(), io::disk_failure(folder, "make the folder");
        std::ofstream file(path, std::ios::binary | std::ios::trunc);
        file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        file.close();
        if (!file) io::disk_failure(path, "write");
        tile.made.bytes = bytes.size();
    }

    [[nodiscard]] std::vector<std::byte> picture(const SampleFinder& finder, Tile& tile) const {
        const HeightColours colours =
            options_.format == TilesFormat::terrarium ? HeightColours::terrarium : HeightColours::terrain_rgb;
        RasterTile made = named([&] {
            return make_raster_tile(surface_, finder, tile.id, {colours, options_.webp, options_.side_px, last_});
        });
        const auto pixels = static_cast<std::uint64_t>(options_.side_px) * static_cast<std::uint64_t>(options_.side_px);
        tile.made = {made.error_m, made.low_m, made.high_m, pixels, 0, 0, 0};
        return std::move(made.image);
    }

    [[nodiscard]] std::vector<std::byte> meshed(const TileRules& rules, Tools& tools, const BorderVertices& wanted,
                                                Tile& tile) const {
        TileMesh mesh = make_tile_mesh(surface_, tools.finder, box_of(tiling_, tile.id), rules, wanted);
        std::vector<GlobePlace> normals;
        if (options_.normals) normals = normals_of(mesh, tools.finder, tile.id.level);
        tile.made = {
            mesh.error_m, 0, 0, mesh.vertices.size(), mesh.triangles.size(), 0, mesh.error_m > rules.tolerance_m};
        std::vector<std::byte> bytes = encode(tile.id, rules, mesh, normals, tools, tile.made);
        tile.borders = std::move(mesh.borders);
        return bytes;
    }

    // A map of the pack over a tile, side_px texels a side.
    [[nodiscard]] std::vector<std::uint8_t> mapped(PackMap& map, std::uint32_t side_px, const DegreeBox& box, int level,
                                                   const SampleFinder& finder) const {
        const double texel_m = tile_m(tiling_, level) / side_px;
        return map.picture(side_px, side_px, texel_m, [&](double u, double v) -> std::optional<std::array<double, 2>> {
            double column = 0, row = 0;
            const LonLat at{box.west + (box.east - box.west) * u, box.north + (box.south - box.north) * v};
            if (!finder.find(at, column, row)) return std::nullopt;
            return std::array{column, row};
        });
    }
    [[nodiscard]] std::vector<std::byte> texture_of(const DegreeBox& box, int level, Tools& tools) const {
        if (!tools.colours) return {};
        constexpr std::uint32_t side_px = 256;
        const std::vector<std::uint8_t> rgb = mapped(*tools.colours, side_px, box, level, tools.finder);
        return gltf::encode_jpeg(side_px, side_px, std::as_bytes(std::span(rgb)));
    }
    // As quantized-mesh has it: a byte for all of the tile where it is all land or all water.
    [[nodiscard]] std::vector<std::byte> water_of(const DegreeBox& box, int level, Tools& tools) const {
        std::vector<std::byte> mask;
        if (!tools.water) return mask;
        const std::vector<std::uint8_t> rgb = mapped(*tools.water, water_mask_px, box, level, tools.finder);
        for (std::size_t i = 0; i < rgb.size(); i += 3) mask.push_back(std::byte{rgb[i]});
        const auto differs = [&](std::byte b) { return b != mask.front(); };
        const bool ends = mask.front() == std::byte{0} || mask.front() == std::byte{255};
        if (ends && std::ranges::none_of(mask, differs)) mask.resize(1);
        return mask;
    }

    // What goes wrong says of what.
    template <typename Make>
    [[nodiscard]] std::invoke_result_t<Make> named(const Make& make) const {
        try {
            return make();
        } catch (const Failure& failure) {
            throw Failure(failure.exit_code, fmt::format("{}: {}", name_, failure.what()));
        }
    }

    [[nodiscard]] std::vector<std::byte> encode(TileId id, const TileRules& rules, const TileMesh& mesh,
                                                std::span<const GlobePlace> normals, Tools& tools, Made& made) const {
        if (is_tileset()) {
            // Beside a tile of the next coarser level: its own error, and that one's, which is twice as large.
            constexpr double diagonal = 1.5; // with walls
            const double size_m = diagonal * tile_m(tiling_, id.level) + relief_m();
            GltfTile tile =
                encode_gltf_tile(mesh, {rules.tolerance_m, size_m, options_.packing, options_.implicit_tree}, normals,
                                 texture_of(mesh.box, id.level, tools));
            made.error_m = tile.error_m;
            made.low_m = tile.low_m, made.high_m = tile.high_m;
            return std::move(tile.bytes);
        }
        const std::string available = id.level == 0 ? json(available_.begin() + 1, available_.end()).dump() : "";
        EncodedTile tile = named([&] {
            return encode_quantized_mesh(mesh, rules.height_step_m,
                                         {normals, water_of(mesh.box, id.level, tools), available});
        });
        made.low_m = tile.low_m, made.high_m = tile.high_m;
        return options_.gzip ? gzip(tile.bytes) : std::move(tile.bytes);
    }

    // Of the ground itself, over about as much as a triangle covers.
    [[nodiscard]] std::vector<GlobePlace> normals_of(const TileMesh& mesh, const SampleFinder& finder,
                                                     int level) const {
        constexpr double share = 1.0 / 128, degree_m = 111.2e3, least_cosine = 1e-3;
        const double away = std::max(surface_.spacing_m(), tile_m(tiling_, level) * share) / degree_m;
        std::vector<GlobePlace> normals;
        for (const TileMesh::Vertex& v : mesh.vertices) {
            const LonLat at = mesh.place(v);
            const GlobePlace up = up_at(at);
            const double c = std::max(least_cosine, std::hypot(up[0], up[1]));
            const auto height = [&](double east_by, double north_by) {
                return surface_.height_m(finder, {near_longitude(at.longitude + east_by / c, 0),
                                                  std::clamp(at.latitude + north_by, -90.0, 90.0)});
            };
            const double across = 2 * away * degree_m;
            const double by_east = (height(away, 0) - height(-away, 0)) / across,
                         by_north = (height(0, away) - height(0, -away)) / across;
            const double angle = at.longitude * std::numbers::pi / 180;
            const GlobePlace e{-std::sin(angle), std::cos(angle), 0},
                n{up[1] * e[2] - up[2] * e[1], up[2] * e[0] - up[0] * e[2], up[0] * e[1] - up[1] * e[0]};
            GlobePlace normal{};
            for (std::size_t axis = 0; axis < 3; ++axis)
                normal[axis] = up[axis] - by_east * e[axis] - by_north * n[axis];
            const double length = std::hypot(normal[0], normal[1], normal[2]);
            for (double& axis : normal) axis /= length;
            normals.push_back(normal);
        }
        return normals;
    }

    static LevelSummary summary_of(int level, double assumed_m, const std::vector<Tile>& tiles) {
        LevelSummary s{level, assumed_m};
        for (const Tile& tile : tiles) {
            ++s.tiles;
            s.error_m = std::max(s.error_m, tile.made.error_m);
            s.vertices += tile.made.vertices, s.triangles += tile.made.triangles, s.bytes += tile.made.bytes;
            s.above += tile.made.above;
        }
        return s;
    }

    // Rectangles that cover these tiles and no others; ids: row by row.
    static json runs(const std::vector<TileId>& ids) {
        struct Run {
            std::int32_t x0, y0, x1, y1;
        };
        std::vector<Run> all;
        std::map<std::pair<std::int32_t, std::int32_t>, std::size_t> open; // by x0, x1, in the row before
        for (std::size_t i = 0; i < ids.size();) {
            const std::int32_t y = ids[i].y;
            std::map<std::pair<std::int32_t, std::int32_t>, std::size_t> row;
            while (i < ids.size() && ids[i].y == y) {
                std::size_t end = i + 1;
                while (end < ids.size() && ids[end].y == y && ids[end].x == ids[end - 1].x + 1) ++end;
                const std::pair columns{ids[i].x, ids[end - 1].x};
                const auto above = open.find(columns);
                if (above != open.end() && all[above->second].y1 == y - 1) {
                    row[columns] = above->second;
                    all[above->second].y1 = y;
                } else {
                    row[columns] = all.size();
                    all.push_back({columns.first, y, columns.second, y});
                }
                i = end;
            }
            open = std::move(row);
        }
        json list = json::array();
        for (const Run& r : all) list.push_back({{"startX", r.x0}, {"startY", r.y0}, {"endX", r.x1}, {"endY", r.y1}});
        return list;
    }

    [[nodiscard]] DegreeBox bounds(const std::vector<TileId>& ids) const {
        DegreeBox all{180, 90, -180, -90};
        for (const TileId& id : ids) {
            const DegreeBox b = box_of(tiling_, id);
            all = {std::min(all.west, b.west), std::min(all.south, b.south), std::max(all.east, b.east),
                   std::max(all.north, b.north)};
        }
        return all;
    }

    [[nodiscard]] json about(const TilesSummary& summary) const {
        const CrsLabel crs = crs_label(surface_.source().crs_wkt);
        json levels = json::array();
        for (const LevelSummary& l : summary.levels) {
            levels.push_back({{"level", l.level}, {"tiles", l.tiles}, {"error_m", l.error_m}});
            if (!is_raster())
                levels.back()["triangles"] = l.triangles, levels.back()["assumed_error_m"] = l.assumed_error_m;
        }
        const std::string vertical = vertical_name(surface_.source().crs_wkt);
        return {{"source", surface_.source().identity()},
                {"crs", crs_text(crs)},
                {"vertical_unit", "m"},
                {"vertical_datum", vertical.empty() ? json() : json(vertical)},
                {"heights", is_raster() ? "metres as the source counts them"
                                        : "metres as the source counts them, taken as heights over WGS 84"},
                {"levels", levels}};
    }

    [[nodiscard]] std::string index(const TilesSummary& summary) const {
        return (is_raster() ? picture_index(summary) : layer_index(summary)).dump(1) + "\n";
    }

    // TileJSON, with what a source of MapLibre has besides.
    [[nodiscard]] json picture_index(const TilesSummary& summary) const {
        // MapLibre asks for the tiles beyond where a side of the bounds lies on that of a tile, but for a rounding.
        constexpr double share = 1e-6;
        const double by = share * 360 / tiles_across(tiling_, summary.levels.back().level);
        return {{"tilejson", "3.0.0"},
                {"name", fs::path(name_).stem().string()},
                {"tiles", {std::string("{z}/{x}/{y}") + picture_ending()}},
                {"scheme", "xyz"},
                {"encoding", options_.format == TilesFormat::terrarium ? "terrarium" : "mapbox"},
                {"tileSize", options_.side_px},
                {"minzoom", 0},
                {"maxzoom", summary.levels.back().level},
                {"bounds", {bounds_.west + by, bounds_.south + by, bounds_.east - by, bounds_.north - by}},
                {"fjell", about(summary)}};
    }

    [[nodiscard]] json layer_index(const TilesSummary& summary) const {
        json layer{{"tilejson", "2.1.0"},
                   {"name", fs::path(name_).stem().string()},
                   {"version", "1.0.0"},
                   {"format", "quantized-mesh-1.0"},
                   {"scheme", "tms"},
                   {"projection", tiling_ == Tiling::geographic ? "EPSG:4326" : "EPSG:3857"},
                   {"tiles", {"{z}/{x}/{y}.terrain?v={version}"}},
                   {"minzoom", 0},
                   {"maxzoom", summary.levels.back().level},
                   {"bounds", {bounds_.west, bounds_.south, bounds_.east, bounds_.north}},
                   {"available", available_},
                   // CesiumJS reads a tile's metadata only where this says that some have availability: the roots, of
                   // all levels below them.
                   {"metadataAvailability", std::max<std::size_t>(2, available_.size())},
                   {"extensions", {"metadata"}}};
        if (options_.normals) layer["extensions"].push_back("octvertexnormals");
        if (options_.water) layer["extensions"].push_back("watermask");
        layer["fjell"] = about(summary);
        return layer;
    }
    void write_text(const std::string& name, const std::string& text) const {
        write_file(name, std::as_bytes(std::span(text)));
    }
    void write_file(const std::string& name, std::span<const std::byte> bytes) const {
        io::AtomicFile file(folder_ + "/" + name);
        file.write(bytes);
        file.commit();
    }

    const GroundSurface& surface_;
    const std::string& name_;
    const TilesOptions& options_;
    const Tiling tiling_;
    const std::string &folder_, &work_;
    const int threads_;
    Toolbox toolbox_;
    json available_ = json::array();
    DegreeBox bounds_;
    int first_ = 0, last_ = 0; // levels
    std::vector<ArchiveTile> written_;
};

// What the bytes depend on.
std::string job_of(const HeightSource& source, const TilesOptions& options, Tiling tiling, Archive archive) {
    return fmt::format("fjell tiles 4\n{}\nformat {}\ntiling {}\nmax level {}\nnormals {}\ngzip {}\nquantised {}\n"
                       "meshopt {}\nimplicit {}\npixels {}\nwebp {}\ncolours {}\nwater {}\narchive {}\n",
                       source.identity(), static_cast<int>(options.format), static_cast<int>(tiling), options.max_level,
                       options.normals, options.gzip, options.packing.quantised, options.packing.meshopt,
                       options.implicit_tree, options.side_px, options.webp, options.colours, options.water,
                       static_cast<int>(archive));
}

void check(const TilesOptions& options, Tiling tiling, Archive archive, const std::string& path) {
    if ((options.packing.quantised || options.packing.meshopt) && options.format != TilesFormat::tiles_3d)
        throw Failure(2, "--quantised and --meshopt are for --format 3dtiles; leave them out, or add it");
    if (options.implicit_tree && options.format != TilesFormat::tiles_3d)
        throw Failure(2, "--implicit is for --format 3dtiles; leave it out, or add that");
    if (options.implicit_tree && tiling != Tiling::geographic)
        throw Failure(2,
                      "--tiling mercator: an implicit tree halves degrees; leave out one of --implicit and --tiling");
    if (options.colours && options.format != TilesFormat::tiles_3d)
        throw Failure(2, "--colours is for --format 3dtiles; leave it out, or add that");
    if (options.webp && !is_raster(options.format))
        throw Failure(2, "--image is for --format terrain-rgb and terrarium; leave it out, or add one of them");
    if (is_raster(options.format) && tiling != Tiling::mercator)
        throw Failure(2, "--tiling geographic: pictures of heights are in Web Mercator alone; leave it out");
    if (archive != Archive::folder && options.format == TilesFormat::tiles_3d)
        throw Failure(2, fmt::format("{}: 3D Tiles are written as a folder; give a name without such an ending", path));
    if (archive == Archive::pmtiles && tiling != Tiling::mercator)
        throw Failure(2, fmt::format("{}: PMTiles count their tiles in Web Mercator; add --tiling mercator", path));
}

bool is_empty(const std::string& folder) {
    std::error_code error;
    return !fs::exists(folder, error) || (fs::is_directory(folder, error) && fs::is_empty(folder, error));
}

} // namespace

TilesSummary write_tiles(const HeightSource& source, const std::string& name, const TilesOptions& options,
                         const std::string& given) {
    std::string out = given;
    while (out.size() > 1 && out.ends_with('/')) out.pop_back();
    const Tiling tiling = options.tiling.value_or(is_raster(options.format) ? Tiling::mercator : Tiling::geographic);
    const Archive archive = archive_of(out);
    check(options, tiling, archive, out);
    if (options.colours) (void)PackMap(options.maps_of, PackMap::Kind::colour); // it has some
    const int last = last_level(source, name, options, tiling);
    const std::string job = job_of(source, options, tiling, archive), job_file = out + ".work/job";
    std::error_code none;
    const bool resumed = fs::exists(job_file, none) && io::read_text(job_file) == job;
    if (!resumed && !is_empty(out))
        throw Failure(1, fmt::format("{}: holds something else already; remove it, or choose a new {}", out,
                                     archive == Archive::folder ? "folder" : "name"));
    WorkFolder work(out);
    work.keep(false); // until there is something to go on with
    if (!resumed) work.empty();
    const GroundSurface surface(
        source, name, {work.path(), options.memory_bytes, resolve_threads(options.threads), options.progress});
    if (!resumed) {
        io::AtomicFile file(job_file);
        file.write(std::as_bytes(std::span(job)));
        file.commit();
    }
    work.keep();
    const std::string folder = archive == Archive::folder ? out : work.file("tiles");
    fs::create_directories(folder, none);
    if (none) errno = none.value(), io::disk_failure(folder, "make the folder");
    Pyramid pyramid(surface, name, options, tiling, folder, work.path());
    TilesSummary summary = pyramid.write(last);
    pyramid.archive(archive, summary, out);
    summary.resumed = resumed;
    work.keep(false);
    return summary;
}

} // namespace fjell::baker
