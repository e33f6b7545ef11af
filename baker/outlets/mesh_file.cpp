#include "baker/outlets/mesh_file.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "baker/georeference/crs_label.h"
#include "baker/outlets/areas.h"
#include "baker/outlets/height_mesh.h"
#include "baker/outlets/pack_map.h"
#include "baker/outlets/read_ground.h"
#include "gltf/texels.h"
#include "io/file.h"

namespace fjell::baker {

namespace {

using nlohmann::ordered_json;
using Corner3 = std::array<float, 3>;

enum class MeshFormat : std::uint8_t { glb, ply, obj, stl };
constexpr const char* mesh_endings[] = {".glb", ".ply", ".obj", ".stl"};

MeshFormat format_of(const std::string& path) {
    std::string ending = std::filesystem::path(path).extension().string();
    std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    for (std::size_t i = 0; i < std::size(mesh_endings); ++i)
        if (ending == mesh_endings[i]) return static_cast<MeshFormat>(i);
    throw Failure(
        2, fmt::format("{}: meshes are written as {}; give a name that ends so", path, fmt::join(mesh_endings, ", ")));
}

bool is_z_up(MeshFormat format) {
    return format == MeshFormat::ply || format == MeshFormat::stl;
}

// Bytes on their way into a file, or only counted.
class Sink {
public:
    explicit Sink(io::AtomicFile* file) : file_(file) { bytes_.reserve(room); }
    template <typename T>
    void put(const T& value) {
        put(std::as_bytes(std::span(&value, 1)));
    }
    void put(const std::string& text) { put(std::as_bytes(std::span(text))); }
    void put(std::span<const std::byte> bytes) {
        bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
        if (bytes_.size() >= room) flush();
    }
    void flush() {
        io::check_interrupt();
        if (file_ != nullptr) file_->write(bytes_);
        size_ += bytes_.size();
        bytes_.clear();
    }
    [[nodiscard]] std::uint64_t size() const { return size_; } // after flush()

private:
    static constexpr std::size_t room = std::size_t{1} << 20;
    io::AtomicFile* const file_; // null: only counted
    std::uint64_t size_ = 0;
    std::vector<std::byte> bytes_;
};

struct Claim {
    const HeightSource& source;
    const MeshFileSummary& summary;

    [[nodiscard]] ordered_json json() const {
        const MeshFileSummary& s = summary;
        const std::string vertical = vertical_name(source.crs_wkt);
        return {{"max_error_m", s.max_error_m},
                {"true_error_m", s.true_error_m},
                {"error_holds", "at every sample: its vertical distance from the mesh"},
                {"columns", s.columns},
                {"rows", s.rows},
                {"spacing_m", {source.spacing_m[0], source.spacing_m[1]}},
                {"crs", crs_text(crs_label(source.crs_wkt))},
                {"vertical_unit", "m"},
                {"vertical_datum", vertical.empty() ? ordered_json() : ordered_json(vertical)},
                {"crs_origin", {source.crs_origin[0], source.crs_origin[1]}},
                {"holes", s.holes},
                {"left_out", s.left_out},
                {"triangles", s.ground_triangles}};
    }
    // One line each.
    [[nodiscard]] std::vector<std::string> lines(const char* axes) const {
        const MeshFileSummary& s = summary;
        return {fmt::format("Fjell: no sample is farther than {} m above or below this mesh; {} m were allowed",
                            s.true_error_m, s.max_error_m),
                fmt::format("{}, metres from sample (0, 0) of {} x {}, {} x {} m apart", axes, s.columns, s.rows,
                            source.spacing_m[0], source.spacing_m[1]),
                fmt::format("sample (0, 0) is at {} {} of {}", source.crs_origin[0], source.crs_origin[1],
                            crs_text(crs_label(source.crs_wkt)))};
    }
};

// ---- .glb

// Of the ground at a sample, eastwards and southwards, from what neighbours it has.
std::array<double, 2> slope_at(const Ground& ground, std::int64_t x, std::int64_t y) {
    const auto slope = [&](std::int64_t dx, std::int64_t dy, double spacing_m) {
        const auto height = [&](std::int64_t i, std::int64_t j) {
            const bool inside = i >= 0 && j >= 0 && i < ground.columns && j < ground.rows;
            return inside ? static_cast<double>(ground.row(j)[i]) : std::nan("");
        };
        const double before = height(x - dx, y - dy), here = height(x, y), after = height(x + dx, y + dy);
        if (std::isnan(before) && std::isnan(after)) return 0.0;
        if (std::isnan(before)) return (after - here) / spacing_m;
        if (std::isnan(after)) return (here - before) / spacing_m;
        return (after - before) / (2 * spacing_m);
    };
    return {slope(1, 0, ground.spacing_m[0]), slope(0, 1, ground.spacing_m[1])};
}
Vec3 normal_of(const std::array<double, 2>& slope) {
    return normalised(Vec3{-slope[0], 1, -slope[1]});
}

// Over all samples, as fine as they are or as few texels as a texture may have.
gltf::TexelGrid texels_over(const Ground& ground) {
    constexpr double most_px = 2048, fewest_px = 4;
    const double cells_x = ground.columns - 1.0, cells_y = ground.rows - 1.0;
    const double wide_m = cells_x * ground.spacing_m[0], high_m = cells_y * ground.spacing_m[1];
    const double texel_m =
        std::max({wide_m / (most_px - 1), high_m / (most_px - 1), std::min(ground.spacing_m[0], ground.spacing_m[1])});
    const auto side_px = [&](double m) {
        return static_cast<std::uint32_t>(std::clamp(std::round(m / texel_m) + 1, fewest_px, most_px));
    };
    return {side_px(wide_m), side_px(high_m), cells_x, cells_y};
}

// The mean of the slopes around a texel: between samples, or of as many as it covers.
gltf::NormalAt normals_over(const Ground& ground, const gltf::TexelGrid& grid) {
    return [&ground, grid](double texel_x, double texel_y) {
        const double x = texel_x / grid.per_cell_x(), y = texel_y / grid.per_cell_y();
        const double reach_x = std::max(1.0, 1 / grid.per_cell_x()), reach_y = std::max(1.0, 1 / grid.per_cell_y());
        const auto from = [](double p) { return std::max<std::int64_t>(0, std::llround(std::ceil(p))); };
        const auto to = [](double p, std::int32_t samples) {
            return std::min<std::int64_t>(samples - 1, std::llround(std::floor(p)));
        };
        std::array<double, 2> mean{};
        double all = 0;
        for (std::int64_t j = from(y - reach_y); j <= to(y + reach_y, ground.rows); ++j)
            for (std::int64_t i = from(x - reach_x); i <= to(x + reach_x, ground.columns); ++i) {
                if (std::isnan(ground.row(j)[i])) continue;
                const double share = std::max(0.0, 1 - std::abs(static_cast<double>(i) - x) / reach_x) *
                                     std::max(0.0, 1 - std::abs(static_cast<double>(j) - y) / reach_y);
                const std::array<double, 2> slope = slope_at(ground, i, j);
                mean[0] += share * slope[0], mean[1] += share * slope[1];
                all += share;
            }
        if (all > 0) mean[0] /= all, mean[1] /= all;
        return normal_of(mean);
    };
}

std::vector<gltf::SnapshotVertex> glb_vertices(const HeightMesh& mesh, const Ground& ground) {
    std::vector<gltf::SnapshotVertex> vertices;
    vertices.reserve(mesh.vertices.size());
    for (const Corner3& at : mesh.vertices) {
        const std::int64_t column = std::lround(static_cast<double>(at[0]) / ground.spacing_m[0]),
                           row = std::lround(static_cast<double>(at[2]) / ground.spacing_m[1]);
        const Vec3 n = normal_of(slope_at(ground, column, row));
        gltf::SnapshotVertex v{{at[0], at[1], at[2]},
                               {static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)},
                               {static_cast<float>(column), static_cast<float>(row)},
                               {}};
        std::ranges::copy(gltf::tangent_of(v.normal), v.tangent);
        vertices.push_back(v);
    }
    return vertices;
}

// Colours and the share of the sky from the pack's maps; normals from the heights, which its maps are made of too.
gltf::GlbTextures add_textures(gltf::Glb& glb, const gltf::TexelMesh& mesh, const Ground& ground,
                               const gltf::TexelGrid& grid, const MeshFileOptions& options) {
    gltf::GlbTextures textures;
    const auto mapped = [&](PackMap::Kind kind) {
        const double texel_m =
            std::max(ground.spacing_m[0] / grid.per_cell_x(), ground.spacing_m[1] / grid.per_cell_y());
        return PackMap(options.maps_of, kind).picture(grid.columns, grid.rows, texel_m, [&](double u, double v) {
            return std::optional(
                std::array{(u * grid.columns - 0.5) / grid.per_cell_x(), (v * grid.rows - 0.5) / grid.per_cell_y()});
        });
    };
    const auto png = [&](const char* name, const std::vector<std::uint8_t>& rgb) {
        return static_cast<int>(glb.add_texture(
            name, gltf::encode_png(grid.columns, grid.rows, std::as_bytes(std::span(rgb))), "image/png"));
    };
    if (options.colours) {
        const std::vector<std::uint8_t> rgb = mapped(PackMap::Kind::colour);
        textures.colour = static_cast<int>(glb.add_texture(
            "colour", gltf::encode_jpeg(grid.columns, grid.rows, std::as_bytes(std::span(rgb))), "image/jpeg"));
    }
    if (options.normal_map)
        textures.normal = png("normal", gltf::normal_texture(mesh, grid, normals_over(ground, grid)));
    if (options.occlusion) textures.occlusion = png("occlusion", mapped(PackMap::Kind::sky));
    return textures;
}

void write_glb(const HeightMesh& mesh, const Ground& ground, const std::optional<gltf::GlbLattice>& lattice,
               const MeshFileOptions& options, const Claim& claim, Sink& out) {
    gltf::Glb glb("fjell-bake",
                  fmt::format("{} triangles need more bytes than glTF counts; give a larger --max-error-m, a part with "
                              "--bbox, or a name that ends in .ply",
                              mesh.triangles.size()));
    glb.json["asset"]["extras"]["fjell"] = claim.json();
    const std::vector<gltf::SnapshotVertex> vertices = glb_vertices(mesh, ground);
    const std::span indices(mesh.triangles.front().data(), 3 * mesh.triangles.size());
    const gltf::TexelGrid grid = texels_over(ground);
    const auto three = [](const float(&c)[3]) {
        return std::array{static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2])};
    };
    gltf::GlbMesh content{"terrain", vertices.size(), indices};
    content.place = [&](std::size_t i) { return three(vertices[i].position_m); };
    content.normal = [&](std::size_t i) { return three(vertices[i].normal); };
    content.lattice = lattice;
    if (options.colours || options.normal_map || options.occlusion) {
        content.textures = add_textures(glb, {vertices, indices}, ground, grid, options);
        content.uv = [&](std::size_t i) {
            return std::array{grid.u(static_cast<double>(vertices[i].cells[0])),
                              grid.v(static_cast<double>(vertices[i].cells[1]))};
        };
    }
    if (options.normal_map)
        content.tangent = [&](std::size_t i) {
            const auto& t = vertices[i].tangent;
            return std::array{static_cast<double>(t[0]), static_cast<double>(t[1]), static_cast<double>(t[2]),
                              static_cast<double>(t[3])};
        };
    gltf::add_glb_mesh(glb, std::move(content), options.packing.meshopt);
    glb.close();
    glb.write([&](std::span<const std::byte> bytes) { out.put(bytes); });
}

// ---- .ply, .obj

void write_ply(const HeightMesh& mesh, const Claim& claim, Sink& out) {
    std::string header = "ply\nformat binary_little_endian 1.0\n";
    for (const std::string& line : claim.lines("x east, y north, z up")) header += "comment " + line + "\n";
    header += fmt::format("element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
                          "element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
                          mesh.vertices.size(), mesh.triangles.size());
    out.put(header);
    for (const Corner3& v : mesh.vertices) out.put(v);
    for (const auto& t : mesh.triangles) out.put(std::uint8_t{3}), out.put(t);
}

void write_obj(const HeightMesh& mesh, const Claim& claim, Sink& out) {
    for (const std::string& line : claim.lines("x east, y up, z south")) out.put("# " + line + "\n");
    out.put(std::string("o terrain\n"));
    for (const Corner3& v : mesh.vertices) out.put(fmt::format("v {} {} {}\n", v[0], v[1], v[2]));
    for (const auto& t : mesh.triangles)
        out.put(fmt::format("f {} {} {}\n", std::uint64_t{t[0]} + 1, std::uint64_t{t[1]} + 1, std::uint64_t{t[2]} + 1));
}

// ---- .stl

// Edges that only one triangle has, as it runs along them: of the rim, and of holes.
std::vector<std::array<std::uint32_t, 2>> open_edges(const HeightMesh& mesh) {
    std::vector<std::uint64_t> there, back; // from << 32 | to
    there.reserve(mesh.triangles.size() * 3), back.reserve(mesh.triangles.size() * 3);
    for (const auto& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint64_t a = t[k], b = t[(k + 1) % 3];
            there.push_back(a << 32 | b), back.push_back(b << 32 | a);
        }
    std::sort(there.begin(), there.end());
    std::sort(back.begin(), back.end());
    std::vector<std::uint64_t> open;
    std::set_difference(there.begin(), there.end(), back.begin(), back.end(), std::back_inserter(open));
    std::vector<std::array<std::uint32_t, 2>> edges;
    edges.reserve(open.size());
    for (const std::uint64_t edge : open)
        edges.push_back({static_cast<std::uint32_t>(edge >> 32), static_cast<std::uint32_t>(edge)});
    return edges;
}

void put_facet(Sink& out, const Corner3& a, const Corner3& b, const Corner3& c) {
    const auto from = [&](const Corner3& p, std::size_t axis) {
        return static_cast<double>(p[axis]) - static_cast<double>(a[axis]);
    };
    double n[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        n[axis] = from(b, u) * from(c, v) - from(b, v) * from(c, u);
    }
    const double length = std::max(std::hypot(n[0], n[1], n[2]), 1e-300);
    out.put(Corner3{static_cast<float>(n[0] / length), static_cast<float>(n[1] / length),
                    static_cast<float>(n[2] / length)});
    out.put(a), out.put(b), out.put(c);
    out.put(std::uint16_t{0});
}

std::uint64_t write_stl(const HeightMesh& mesh, const Ground& ground, const MeshFileOptions& options,
                        const Claim& claim, Sink& out) {
    const std::vector<std::array<std::uint32_t, 2>> edges = open_edges(mesh);
    const std::uint64_t facets = mesh.triangles.size() + mesh.base.size() + 2 * edges.size();
    if (facets > 0xffff'ffff)
        throw Failure(1, fmt::format("{} triangles are more than STL counts; give a larger --max-error-m", facets));
    const double longer_m =
        std::max((ground.columns - 1) * ground.spacing_m[0], (ground.rows - 1) * ground.spacing_m[1]);
    constexpr double share = 1.0 / 20;
    const double thickness_m = options.base_m >= 0 ? options.base_m : longer_m * share;
    const float floor_m = static_cast<float>(static_cast<double>(ground.min_m) - thickness_m);
    if (!(floor_m < ground.min_m))
        throw Failure(2, fmt::format("--base-m {}: the base touches the ground at {} m; give more, or the solid is "
                                     "open there",
                                     options.base_m, ground.min_m));
    std::string header =
        fmt::format("Fjell: no sample is farther than {:.6g} m from the top; metres", claim.summary.true_error_m);
    header.resize(80, ' ');
    out.put(header);
    out.put(static_cast<std::uint32_t>(facets));
    const auto under = [&](std::uint32_t i) { return Corner3{mesh.vertices[i][0], mesh.vertices[i][1], floor_m}; };
    for (const auto& t : mesh.triangles) put_facet(out, mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
    for (const auto& t : mesh.base) put_facet(out, under(t[0]), under(t[2]), under(t[1]));
    for (const auto& [a, b] : edges) {
        put_facet(out, mesh.vertices[b], mesh.vertices[a], under(a));
        put_facet(out, mesh.vertices[b], under(a), under(b));
    }
    return facets;
}

// ---- the mesh

// Columns and rows are whole numbers by themselves. Heights may take half of the bound for their steps: then a quarter
// of it is rounding, and normals, which are scaled like places, keep most of their digits.
std::optional<gltf::GlbLattice> lattice_of(const Ground& ground, const MeshFileOptions& options, double max_error_m) {
    if (!options.packing.quantised) return {};
    if (std::max(ground.columns, ground.rows) > gltf::GlbLattice::most + 1)
        throw Failure(1,
                      fmt::format("--quantised: 16 bits count 65536 samples a side, and there are {} x {}; give a part "
                                  "with --bbox",
                                  ground.columns, ground.rows));
    const double low_m = static_cast<double>(ground.min_m), relief_m = static_cast<double>(ground.max_m) - low_m;
    const double step_m = std::max({max_error_m / 2, relief_m / gltf::GlbLattice::most, 1e-6});
    return gltf::GlbLattice{{0, low_m, 0}, {ground.spacing_m[0], step_m, ground.spacing_m[1]}};
}

// What the lattice adds to an error: half a step, and what a viewer's floats are off.
double lattice_rounding_m(const std::optional<gltf::GlbLattice>& lattice, const Ground& ground) {
    constexpr double float_share = 1.0 / (1 << 23);
    const auto size = [](float height_m) { return std::abs(static_cast<double>(height_m)); };
    return lattice ? lattice->scale[1] / 2 + float_share * std::max(size(ground.min_m), size(ground.max_m)) : 0;
}

HeightMesh mesh_within(const Ground& ground, const MeshFileOptions& options, MeshFormat format, double max_error_m) {
    const double rest_m = max_error_m - lattice_rounding_m(lattice_of(ground, options, max_error_m), ground);
    HeightMeshOptions wanted{{ground.spacing_m[0], ground.spacing_m[1]}, std::max(0.0, rest_m)};
    wanted.z_up = is_z_up(format), wanted.base = format == MeshFormat::stl, wanted.threads = options.threads;
    return mesh_heights(ground.array(), wanted);
}

// Halves the interval of errors: a larger one never keeps more triangles.
HeightMesh mesh_of_at_most(std::uint64_t most, const Ground& ground, const MeshFileOptions& options, MeshFormat format,
                           double& max_error_m) {
    double over_m = 0, under_m = std::max(1e-3, static_cast<double>(ground.max_m) - static_cast<double>(ground.min_m));
    HeightMesh best = mesh_within(ground, options, format, under_m);
    if (best.triangles.size() > most)
        throw Failure(
            2, fmt::format("--max-triangles {}: the coarsest mesh has {}; give as many", most, best.triangles.size()));
    max_error_m = under_m;
    constexpr int rounds = 14;
    constexpr double near = 0.98; // of the target
    for (int i = 0; i < rounds && static_cast<double>(best.triangles.size()) < near * static_cast<double>(most); ++i) {
        const double lowest_m = std::max(over_m, under_m * 1e-4); // errors matter by their ratios
        const double middle_m = std::sqrt(lowest_m * under_m);
        HeightMesh mesh = mesh_within(ground, options, format, middle_m);
        if (mesh.triangles.size() > most) {
            over_m = middle_m;
        } else {
            under_m = max_error_m = middle_m;
            best = std::move(mesh);
        }
    }
    return best;
}

// What lies outside becomes a hole; how many samples with a height did.
std::uint64_t leave_out(Ground& ground, const Areas& areas) {
    std::uint64_t count = 0;
    ground.min_m = HUGE_VALF, ground.max_m = -HUGE_VALF;
    std::vector<float> kept(static_cast<std::size_t>(ground.columns));
    for (std::int32_t y = 0; y < ground.rows; ++y) {
        std::ranges::fill(kept, std::nanf(""));
        std::uint64_t here = 0;
        const float* const row = ground.row(y);
        for (const auto& [first, end] : areas.inside(y)) std::copy(row + first, row + end, kept.begin() + first);
        for (std::int32_t x = 0; x < ground.columns; ++x) {
            const float h = kept[static_cast<std::size_t>(x)];
            here += !std::isnan(row[x]) && std::isnan(h);
            if (!std::isnan(h)) ground.min_m = std::min(ground.min_m, h), ground.max_m = std::max(ground.max_m, h);
        }
        count += here;
        ground.heights_m.write({0, y, ground.columns, 1}, kept.data(), ground.columns);
    }
    return count;
}

} // namespace

MeshFileSummary write_mesh_file(const HeightSource& source, const MeshFileOptions& options, const std::string& path) {
    const MeshFormat format = format_of(path);
    for (const auto& [given, name] :
         {std::pair{options.colours, "colours"}, std::pair{options.normal_map, "normal-map"},
          std::pair{options.occlusion, "occlusion"}, std::pair{options.packing.quantised, "quantised"},
          std::pair{options.packing.meshopt, "meshopt"}})
        if (given && format != MeshFormat::glb)
            throw Failure(2, fmt::format("{}: --{} is for .glb; leave it out, or give such a name", path, name));
    if (options.occlusion && !PackMap::has(options.maps_of, PackMap::Kind::sky))
        (void)PackMap(options.maps_of, PackMap::Kind::sky); // says what is missing before the work
    std::optional<io::AtomicFile> file;
    if (options.write) file.emplace(path); // a file that cannot be written should not cost the work
    std::optional<Areas> areas;
    if (!options.polygon.empty()) areas.emplace(options.polygon, source);
    Ground ground = read_ground(source, GroundHoles::as_source, options.threads, options.progress);
    MeshFileSummary s{ground.columns, ground.rows};
    if (areas) s.left_out = leave_out(ground, *areas);
    const auto start = std::chrono::steady_clock::now();
    s.max_error_m = options.max_error_m;
    const HeightMesh mesh = options.max_triangles
                                ? mesh_of_at_most(*options.max_triangles, ground, options, format, s.max_error_m)
                                : mesh_within(ground, options, format, options.max_error_m);
    s.mesh_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (mesh.triangles.empty())
        throw Failure(
            1, fmt::format("{}: no three samples beside each other have heights: there is no ground to mesh", path));
    const std::optional<gltf::GlbLattice> lattice = lattice_of(ground, options, s.max_error_m);
    s.true_error_m = mesh.true_error_m + lattice_rounding_m(lattice, ground);
    if (lattice && s.true_error_m > s.max_error_m)
        throw Failure(1,
                      fmt::format("--max-error-m {}: heights of 16 bits are {} m off here; give that much, a part with "
                                  "--bbox, or leave out --quantised",
                                  s.max_error_m, s.true_error_m));
    if (s.true_error_m > s.max_error_m)
        throw Failure(1, fmt::format("--max-error-m {}: coordinates in float are {} m off so far from sample (0, 0); "
                                     "give that much, or a part with --bbox",
                                     s.max_error_m, mesh.true_error_m));
    s.holes = ground.holes;
    s.vertices = mesh.vertices.size(), s.triangles = s.ground_triangles = mesh.triangles.size();
    const Claim claim{source, s};
    Sink out(file ? &*file : nullptr);
    switch (format) {
    case MeshFormat::glb: write_glb(mesh, ground, lattice, options, claim, out); break;
    case MeshFormat::ply: write_ply(mesh, claim, out); break;
    case MeshFormat::obj: write_obj(mesh, claim, out); break;
    case MeshFormat::stl: s.triangles = write_stl(mesh, ground, options, claim, out); break;
    }
    out.flush();
    if (file) file->commit();
    s.bytes = out.size();
    return s;
}

} // namespace fjell::baker
