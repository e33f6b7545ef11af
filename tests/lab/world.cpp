#include "lab/world.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <numbers>

#include <fmt/format.h>

#include "fjell/io/failure.h"
#include "io/file.h"
#include "io/json.h"
#include "session/path.h"

namespace fjell::lab {

namespace {

constexpr double fov_y_rad = std::numbers::pi / 4;
constexpr std::uint32_t width_px = 1280, height_px = 960;

// FNV-1a: names of packs, the same everywhere.
std::uint64_t hash_of(const std::string& text) {
    std::uint64_t h = 0xcbf29ce484222325ull;
    for (const char c : text) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
    return h;
}

// Heights between samples, and beyond the rim those at the rim.
double height_at(const baker::Dem& dem, double x_m, double z_m) {
    const double x = std::clamp(x_m / dem.spacing_m[0], 0.0, dem.columns - 1.001);
    const double y = std::clamp(z_m / dem.spacing_m[1], 0.0, dem.rows - 1.001);
    const auto column = static_cast<std::int32_t>(x), row = static_cast<std::int32_t>(y);
    const double u = x - column, v = y - row;
    return (dem.at(column, row) * (1 - u) + dem.at(column + 1, row) * u) * (1 - v) +
           (dem.at(column, row + 1) * (1 - u) + dem.at(column + 1, row + 1) * u) * v;
}

session::Ground ground_of(const baker::Dem& dem) {
    session::Ground ground;
    ground.extent_x_m = dem.spacing_m[0] * (dem.columns - 1);
    ground.extent_z_m = dem.spacing_m[1] * (dem.rows - 1);
    ground.cell_m = std::min(dem.spacing_m[0], dem.spacing_m[1]);
    ground.height_m = [&dem](double x, double z) { return height_at(dem, x, z); };
    return ground;
}

View view_from(const session::Ground& ground, Vec3 eye, Vec3 forward, Vec3 up) {
    const double far_m = 2 * (ground.extent_x_m + ground.extent_z_m);
    return make_view(eye, forward, up, fov_y_rad, width_px, height_px, std::min(10.0, ground.cell_m / 6), far_m);
}

// Over the middle, 400 m above ground as a camera follows it, over a hundred cells and not every bump. No longer than
// two fifths of the terrain: fewer frames then.
std::vector<View> straight(const session::Ground& ground, double cells, int frames) {
    const Vec3 direction{0.8, 0, -0.6};
    const double step_m = cells * ground.cell_m, most_m = 0.4 * std::min(ground.extent_x_m, ground.extent_z_m);
    const int count = std::clamp(static_cast<int>(most_m / step_m), 1, frames);
    Vec3 eye = Vec3{ground.extent_x_m / 2, 0, ground.extent_z_m / 2} - direction * (step_m * count / 2);
    std::vector<View> views;
    for (int frame = 0; frame < count; ++frame, eye = eye + direction * step_m) {
        double height_m = 0;
        for (int i = -4; i <= 4; ++i) {
            const Vec3 at = eye + direction * (i * 12 * ground.cell_m);
            height_m += ground.height_m(at.x, at.z) / 9;
        }
        views.push_back(view_from(ground, {eye.x, height_m + 400, eye.z}, {0.8, -0.15, -0.6}, {0, 1, 0}));
    }
    return views;
}

baker::Dem part_of(const baker::Dem& all, std::int32_t column, std::int32_t row, std::int32_t side) {
    baker::Dem part = all;
    part.columns = part.rows = side + 1;
    part.heights_m.clear();
    part.voids.clear();
    for (std::int32_t y = row; y <= row + side; ++y)
        for (std::int32_t x = column; x <= column + side; ++x) part.heights_m.push_back(all.at(x, y));
    return part;
}

} // namespace

World::World(Site site, std::string source_root, std::string real_folder, std::string packs)
    : site_(std::move(site)), source_root_(std::move(source_root)), real_folder_(std::move(real_folder)),
      packs_(std::move(packs)) {}

const baker::Dem& World::dem() {
    if (dem_) return *dem_;
    if (!site_.landscape.is_null()) return dem_.emplace(baker::synthesise_text(site_.landscape.dump()));
    baker::ReadOptions options;
    options.spacing_m = site_.spacing_m;
    options.zscale = site_.zscale;
    options.zoffset_m = site_.zoffset_m;
    return dem_.emplace(baker::read_dem(real_folder_ + "/" + site_.file, options));
}

std::size_t World::samples() {
    return static_cast<std::size_t>(dem().columns) * static_cast<std::size_t>(dem().rows);
}

// Beside the pack lies how long its errors took, for runs that find it baked.
std::string World::pack(const baker::Dem& heights, int tile_log2, const Case& c, const std::string& part) {
    nlohmann::json identity = site_.identity();
    identity.erase("path"); // of the camera
    std::string what = fmt::format("{} {} {} {} {} {}", identity.dump(), tile_log2, static_cast<int>(c.order),
                                   static_cast<int>(c.estimate), part, pack_layout_hash);
    if (c.texture_cells > 0) what += fmt::format(" {}", c.texture_cells);
    const std::string path = fmt::format("{}/{:016x}.fjell", packs_, hash_of(what));
    if (std::filesystem::exists(path) && std::filesystem::exists(path + ".json")) return path;
    std::filesystem::create_directories(packs_);
    baker::BakeOptions options;
    options.tile_log2 = tile_log2;
    options.order = c.order;
    options.estimate = c.estimate;
    constexpr std::uint32_t least_log2 = 4;
    options.max_texture_log2 =
        c.texture_cells == 0
            ? least_log2
            : std::max(least_log2, static_cast<std::uint32_t>(std::max(
                                       0, tile_log2 - std::countr_zero(static_cast<unsigned>(c.texture_cells)))));
    options.threads = 1;
    options.progress = [](const char*, std::uint64_t, std::uint64_t) { io::check_interrupt(); };
    const baker::BakeSummary summary = baker::bake(heights, options, path);
    io::AtomicFile facts(path + ".json");
    const std::string text = nlohmann::json{{"bake_s", summary.seconds_errors}, {"what", what}}.dump() + "\n";
    facts.write(std::as_bytes(std::span(text)));
    facts.commit();
    return path;
}

const io::LoadedPack& World::loaded(const Case& c) {
    const std::string path = pack(dem(), std::countr_zero(static_cast<unsigned>(c.tile_cells)), c, "whole");
    if (path != loaded_name_) {
        loaded_name_.clear();
        drawing_.reset();
        loaded_ = {};
        loaded_ = io::load_pack(path, io::LoadTerrain::yes);
        loaded_name_ = path;
    }
    return loaded_;
}

const Terrain& World::terrain(const Case& c) {
    return loaded(c).terrain;
}

std::uint32_t World::vertex_slots() {
    return static_cast<std::uint32_t>(std::min(std::size_t{1} << 21, samples() + 4096));
}

Drawing* World::drawing(const Case& c) {
    const io::LoadedPack& pack = loaded(c);
    std::string reason;
    if (!drawing_ && !cannot_draw_) drawing_ = Drawing::create(pack, vertex_slots(), reason);
    if (!reason.empty()) {
        cannot_draw_ = true;
        fmt::print(stderr, "fjell-lab: nothing is drawn: {}\n", reason);
    }
    return drawing_.get();
}

double World::bake_s(const Case& c) {
    const std::string path = pack(dem(), std::countr_zero(static_cast<unsigned>(c.tile_cells)), c, "whole") + ".json";
    return io::parse_json(io::read_text(path), path).at("bake_s").get<double>();
}

const std::vector<LeanSquare>& World::lean(const Case& c) {
    const baker::Dem& all = dem();
    const std::int32_t side = std::min(all.columns, all.rows) - 1;
    if (!std::has_single_bit(static_cast<unsigned>(side)) || (all.columns - 1) % side != 0 ||
        (all.rows - 1) % side != 0)
        throw io::Failure(1, fmt::format("lean: the terrain has {} x {} samples, and this method takes squares of "
                                         "2^n + 1 a side; leave it out of methods",
                                         all.columns, all.rows));
    const std::string name = fmt::format("{}", static_cast<int>(c.estimate));
    if (name == lean_name_) return lean_;
    lean_.clear();
    lean_name_ = name;
    Case planar = c;
    planar.order = PageOrder::planar;
    for (std::int32_t row = 0; row + side < all.rows; row += side)
        for (std::int32_t column = 0; column + side < all.columns; column += side) {
            const std::string path =
                pack(part_of(all, column, row, side), std::countr_zero(static_cast<unsigned>(side)), planar,
                     fmt::format("square {} {}", column, row));
            const io::LoadedPack square = io::load_pack(path, io::LoadTerrain::yes);
            const std::size_t strip = std::min(std::size_t{1} << 24, 16 * samples());
            lean_.push_back({std::make_unique<bench::LeanRecursion>(square.terrain, strip), column * all.spacing_m[0],
                             row * all.spacing_m[1]});
        }
    return lean_;
}

Bout& World::bout(const Case& c, int tile_cells) {
    Case one_tile = c; // the lean recursion's case has none
    one_tile.tile_cells = tile_cells;
    const Terrain& own = terrain(one_tile);
    const std::string method = c.json().at("method"), name = loaded_name_ + " " + method;
    if (name == bout_name_) return *bout_;
    bout_name_.clear();
    bout_.reset();
    bout_ = std::make_unique<Bout>(Bout{rivals::ground_of(own), nullptr, nullptr});
    bout_->lean = rivals::make_rival("lean", bout_->ground, own);
    bout_->rival = rivals::make_rival(method, bout_->ground, own);
    bout_name_ = name;
    return *bout_;
}

std::vector<View> World::views(const Case& c, int frames) {
    const session::Ground ground = ground_of(dem());
    if (c.cells_a_frame > 0) return straight(ground, c.cells_a_frame, frames);
    const session::CameraPath path = session::read_path(source_root_ + "/" + site_.path);
    std::vector<View> views;
    for (const session::Pose& pose : session::resample(path, ground, static_cast<std::size_t>(frames)))
        views.push_back(view_from(ground, pose.position_m, pose.direction, pose.up));
    return views;
}

} // namespace fjell::lab
