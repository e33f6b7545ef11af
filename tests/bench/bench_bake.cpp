// The baker's stages and the way back, in samples a second, beside what this machine copies.
//
// Names: stage/scene/parameter. Scene: the north-west 2049 x 2049 samples of content/terrain/mountains.json.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <xxhash.h>
#include <zstd.h>

#include "baker/bake/bake.h"
#include "baker/check/verify.h"
#include "baker/errors/step.h"
#include "baker/errors/unsaturated.h"
#include "baker/heights/scales.h"
#include "baker/pack/encode_page.h"
#include "baker/synth/synth.h"
#include "baker/synth/write_dem.h"
#include "fjell/io/load.h"
#include "fjell/terrain.h"
#include "shared/terrain_data.h"
#include "support/dem.h"

namespace {

using namespace fjell;

const std::string folder = FJELL_BENCH_DIR;

const baker::Dem& dem() {
    static const baker::Dem made =
        baker::synthesise_text(R"({"columns": 2049, "rows": 2049, "spacing_m": 60, "seed": 1, "relief_m": 3000})");
    return made;
}

double samples() {
    return static_cast<double>(dem().heights_m.size());
}

void rate(benchmark::State& state) {
    state.counters["samples/s"] =
        benchmark::Counter(samples() * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

void copy(benchmark::State& state) {
    std::vector<float> to(dem().heights_m.size());
    for (auto _ : state) {
        std::memcpy(to.data(), dem().heights_m.data(), to.size() * sizeof(float));
        benchmark::ClobberMemory();
    }
    state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(2 * to.size() * sizeof(float)));
    rate(state);
}

// The error stage as the bake runs it, tile after tile, without the work files around it: height scale steps, errors by
// themselves, errors and radii of the finest step, which is three quarters of all vertices. pages: and its pages,
// packed.
class ErrorStage {
public:
    explicit ErrorStage(ErrorEstimate estimate) : estimate_(estimate) {
        baker::HeightStatistics heights;
        for_each_tile([&](SampleIndex corner) {
            heights.add(baker::measure_tile(at(corner), side + 1, side + 1, dem().columns));
        });
        const HeightScale height_scale = baker::choose_height_scale(heights, {{60, 60}, 0.1, 0});
        scales_ = baker::choose_scales({tree_, {60, 60}, height_scale, heights, 0.05});
        leaf_ = LeafErrors(scales_.errors, height_scale.quantum_m);
        header_.tile_log2 = static_cast<std::uint32_t>(tree_.tile_log2);
        header_.height_steps = static_cast<std::uint32_t>((heights.most_m - heights.least_m) / height_scale.quantum_m);
        std::copy_n(scales_.level_radius_m, 2 * max_tile_log2, header_.level_radius_m);
    }

    void run(bool pages) {
        for_each_tile([&](SampleIndex corner) { tile(corner, pages); });
    }

private:
    static constexpr std::int32_t side = 512, squares = side / 2;

    static const float* at(SampleIndex c) { return dem().heights_m.data() + dem().index(c.column, c.row); }
    template <typename Visit>
    void for_each_tile(const Visit& visit) {
        for (std::int32_t y = 0; y + 1 < dem().rows; y += side)
            for (std::int32_t x = 0; x + 1 < dem().columns; x += side) visit(SampleIndex{x, y});
    }

    void tile(SampleIndex corner, bool pages) {
        constexpr std::int32_t around = 2, width = 2 * (squares + baker::reach + 2);
        baker::QuantisedHeights ground{tree_, {corner.column - around, corner.row - around, width, width}, {}};
        for (std::int32_t y = 0; y < width; ++y) {
            const std::int32_t row = std::clamp(ground.steps.y + y, 0, dem().rows - 1),
                               x0 = std::max(ground.steps.x, 0), x1 = std::min(ground.steps.x + width, dem().columns);
            baker::quantise(at({x0, row}), static_cast<std::size_t>(x1 - x0), scales_.height_scale,
                            ground.steps.at(x0, ground.steps.y + y));
        }
        const baker::Region region{corner, {corner.column + side, corner.row + side}};
        baker::Patch<std::uint8_t> own;
        baker::unsaturated_errors({ground, region, scales_, leaf_, estimate_, {60, 60}}, own);
        benchmark::DoNotOptimize(own.values.data());
        baker::VertexPlanes<std::int32_t> steps(squares, squares);
        baker::split_planes(ground.steps, steps);
        baker::VertexPlanes<std::uint8_t> error(squares, squares);
        const baker::StepInput level{scales_, tree_,   {60, 60}, 0,    {corner.column / 2, corner.row / 2},
                                     squares, squares, steps,    error};
        baker::leaf_errors(level, leaf_);
        baker::saturate_errors(level);
        baker::Radii radii;
        baker::nest_radii(level, radii);
        benchmark::DoNotOptimize(radii.centre.data());
        constexpr std::int32_t page = page_squares;
        for (std::int32_t j = 0; pages && j < squares; j += page)
            for (std::int32_t i = 0; i < squares; i += page)
                benchmark::DoNotOptimize(
                    baker::encode_step_page({steps, error, nullptr, radii, i, j, &leaf_, scales_.errors, header_, 0})
                        .bytes.data());
    }

    const Tree tree_ = Tree::covering(dem().columns, dem().rows, 9);
    ErrorEstimate estimate_;
    baker::Scales scales_;
    LeafErrors leaf_;
    PackHeader header_{}; // what bounds of pages are counted on
};

void errors(benchmark::State& state, ErrorEstimate estimate, bool pages) {
    ErrorStage stage(estimate);
    for (auto _ : state) stage.run(pages);
    rate(state);
}

std::string bake_once(int threads) {
    std::filesystem::create_directories(folder);
    const std::string path = folder + "/bake.fjell";
    baker::BakeOptions options;
    options.tile_log2 = 9;
    options.threads = threads;
    const auto summary = baker::bake(dem(), options, path);
    benchmark::DoNotOptimize(summary);
    return path;
}

void whole_bake(benchmark::State& state, int threads) {
    for (auto _ : state) (void)bake_once(threads);
    rate(state);
    const io::LoadedPack pack = io::load_pack(folder + "/bake.fjell", io::LoadTerrain::no);
    double geometry = 0;
    const std::uint64_t chunks = chunk_index(pack.pack.header, {ChunkKind::colour, 0, 0});
    for (std::uint64_t i = 0; i < chunks; ++i)
        geometry += static_cast<double>(pack.pack.entry(i).stored_bytes + sizeof(ChunkEntry));
    state.counters["geometry_bytes_per_sample"] = geometry / samples();
    state.counters["file_MB"] = static_cast<double>(pack.file.size()) / 1e6;
}

// The whole pack into memory: what a start costs. As much memory is written as the terrain takes.
void load(benchmark::State& state) {
    const io::LoadedPack pack = io::load_pack(bake_once(0), io::LoadTerrain::no);
    const std::size_t bytes = terrain_bytes(pack.pack.header);
    const io::AlignedMemory memory = io::allocate(bytes);
    Terrain terrain;
    for (auto _ : state)
        if (!load_terrain(pack.pack, {memory.get(), bytes}, terrain).ok()) return state.SkipWithError("damaged");
    rate(state);
    state.counters["MB"] = static_cast<double>(bytes) / 1e6;
}

// Page by page, as streaming does: the finest step's pages of a tile come and go over coarser ones that stay. Beside
// it, in turns with it, what of that zstd takes at least: the same bytes hashed, and decompressed by a decoder that is
// kept.
class DecodedPack {
public:
    explicit DecodedPack(PageOrder order) {
        baker::BakeOptions options;
        options.tile_log2 = 9;
        options.order = order;
        options.max_texture_log2 = 2;
        std::filesystem::create_directories(folder);
        const std::string path = folder + "/decode.fjell";
        (void)baker::bake(dem(), options, path);
        pack_ = io::load_pack(path, io::LoadTerrain::yes);
        last_ = pack_.terrain.pages_per_tile() - 1;
    }
    [[nodiscard]] std::uint32_t tiles() const { return pack_.terrain.tile_count(); }
    [[nodiscard]] std::uint32_t first() const { return last_ - 31; } // of 64 pages of step 1
    [[nodiscard]] double samples() const {
        double sum = 0;
        for (std::uint32_t page = first(); page <= last_; ++page)
            sum += data_of(pack_.terrain).pages.page_vertices(page);
        return sum;
    }

    [[nodiscard]] bool load(std::uint32_t tile) {
        for (std::uint32_t page = first(); page <= last_; ++page) (void)unload_page(pack_.terrain, tile, page);
        bool ok = true;
        for (std::uint32_t page = first(); page <= last_; ++page)
            ok = load_page(pack_.pack, pack_.terrain, tile, page).ok() && ok;
        return ok;
    }
    // As a stream's client and its frame do: decompressed in advance.
    [[nodiscard]] bool insert(std::uint32_t tile) {
        bool ok = true;
        for (std::uint32_t page = first(); page <= last_; ++page) {
            (void)unload_page(pack_.terrain, tile, page);
            const std::span<const std::byte> raw = decompress(tile, page);
            const auto start = Clock::now();
            ok = insert_page(pack_.terrain, tile, page, raw).ok() && ok;
            insert_s += seconds_since(start);
        }
        return ok;
    }
    void hash(std::uint32_t tile) const {
        for (std::uint32_t page = first(); page <= last_; ++page) {
            const std::span<const std::byte> bytes = stored(tile, page);
            benchmark::DoNotOptimize(XXH3_64bits(bytes.data(), bytes.size()));
        }
    }
    void hash_and_decompress(std::uint32_t tile) {
        for (std::uint32_t page = first(); page <= last_; ++page) {
            const std::span<const std::byte> bytes = stored(tile, page);
            benchmark::DoNotOptimize(XXH3_64bits(bytes.data(), bytes.size()));
            benchmark::DoNotOptimize(decompress(tile, page).data());
        }
    }

    using Clock = std::chrono::steady_clock;
    static double seconds_since(Clock::time_point start) {
        return std::chrono::duration<double>(Clock::now() - start).count();
    }
    double insert_s = 0;

private:
    [[nodiscard]] std::span<const std::byte> stored(std::uint32_t tile, std::uint32_t page) const {
        const ChunkEntry e = pack_.pack.entry(chunk_index(pack_.pack.header, {ChunkKind::geometry, tile, page}));
        return pack_.pack.bytes.subspan(e.offset, e.stored_bytes);
    }
    [[nodiscard]] std::span<const std::byte> decompress(std::uint32_t tile, std::uint32_t page) {
        const std::span<const std::byte> bytes = stored(tile, page);
        return {raw_, ZSTD_decompressDCtx(zstd_.get(), raw_, sizeof raw_, bytes.data(), bytes.size())};
    }

    io::LoadedPack pack_;
    std::uint32_t last_ = 0;
    std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> zstd_{ZSTD_createDCtx(), ZSTD_freeDCtx};
    std::byte raw_[max_page_raw_bytes(max_page_vertices)];
};

void decode(benchmark::State& state, PageOrder order) {
    const auto pack = std::make_unique<DecodedPack>(order);
    double decoded = 0, hash_s = 0, zstd_s = 0;
    std::uint32_t tile = 0;
    for (auto _ : state) {
        if (!pack->load(tile)) return state.SkipWithError("damaged");
        decoded += pack->samples();
        state.PauseTiming();
        const std::uint32_t other = (tile + pack->tiles() / 2) % pack->tiles(); // as far away in the cache
        auto start = DecodedPack::Clock::now();
        pack->hash_and_decompress(other);
        zstd_s += DecodedPack::seconds_since(start);
        start = DecodedPack::Clock::now();
        pack->hash((other + 1) % pack->tiles());
        hash_s += DecodedPack::seconds_since(start);
        if (!pack->insert((other + 2) % pack->tiles())) return state.SkipWithError("damaged");
        tile = (tile + 1) % pack->tiles();
        state.ResumeTiming();
    }
    state.counters["samples/s"] = benchmark::Counter(decoded, benchmark::Counter::kIsRate);
    state.counters["hash_samples/s"] = decoded / hash_s;
    state.counters["hash+zstd_samples/s"] = decoded / zstd_s;
    state.counters["insert_samples/s"] = decoded / pack->insert_s;
}

// The program on its own, so that its resident memory is its own too.
struct ProgramRun {
    bool ok = false;
    nlohmann::json summary;
    [[nodiscard]] double resident_mb() const { return summary["resident_mb_max"]; }
};
ProgramRun run_bake(std::vector<std::string> arguments) {
    const std::string program = FJELL_BIN_DIR "/fjell-bake", json = folder + "/bake.json";
    arguments.insert(arguments.begin(), program);
    arguments.insert(arguments.end(), {"--quiet", "--json", json});
    std::vector<char*> argv;
    for (std::string& a : arguments) argv.push_back(a.data());
    argv.push_back(nullptr);
    ProgramRun run;
    pid_t child = 0;
    int status = 1;
    if (posix_spawn(&child, program.c_str(), nullptr, nullptr, argv.data(), environ) != 0 ||
        waitpid(child, &status, 0) != child || status != 0)
        return run;
    std::ifstream file(json);
    run.summary = nlohmann::json::parse(file, nullptr, false);
    run.ok = run.summary.is_object();
    return run;
}

// The GeoTIFF that programs bake; empty, and the benchmark skipped, where it cannot be made.
std::string tiled_mountains(benchmark::State& state, const std::string& options) {
    std::string dem_path = folder + "/mountains-4097" + options + ".tif";
    if (std::filesystem::exists(dem_path)) return dem_path;
    std::filesystem::create_directories(folder);
    baker::write_dem(*baker::open_synth(FJELL_SOURCE_DIR "/content/terrain/mountains.json"), folder + "/m.tif");
    const std::string command = "gdal_translate -q -co TILED=YES " +
                                std::string(options.empty() ? "" : "-co COMPRESS=DEFLATE -co PREDICTOR=2 ") + folder +
                                "/m.tif " + dem_path;
    if (std::system(command.c_str()) == 0) return dem_path;
    state.SkipWithError("gdal_translate (package gdal-bin) is missing");
    return {};
}

// From a file, as users do it: everything from decoding the GeoTIFF to the pack on the disk.
void program(benchmark::State& state, const std::string& options, int threads,
             const std::vector<std::string>& more = {}) {
    const std::string dem_path = tiled_mountains(state, options);
    if (dem_path.empty()) return;
    std::vector<std::string> arguments{dem_path, "-o", folder + "/bake.fjell", "--threads", std::to_string(threads)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    ProgramRun run;
    for (auto _ : state) {
        run = run_bake(arguments);
        if (!run.ok) return state.SkipWithError("fjell-bake failed");
    }
    state.counters["samples/s"] =
        benchmark::Counter(4097.0 * 4097 * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
    state.counters["resident_MB"] = run.resident_mb();
}

// A pack with a crater of a thousandth of the terrain, beside a bake of all of it in the same run.
void apply(benchmark::State& state) {
    const std::string dem_path = tiled_mountains(state, ""), pack = folder + "/whole.fjell";
    if (dem_path.empty()) return;
    const std::string stamps = folder + "/crater.json";
    std::ofstream(stamps)
        << R"({"stamps": [{"shape": "crater", "at": [60000, 70000], "radius_m": 3000, "falloff_m": 800, "amount_m": 20}]})";
    const ProgramRun whole = run_bake({dem_path, "-o", pack, "--threads", "1"});
    if (!whole.ok) return state.SkipWithError("fjell-bake failed");
    double apply_s = 0;
    ProgramRun run;
    for (auto _ : state) {
        run = run_bake({"apply", pack, stamps, "-o", folder + "/dug.fjell", "--threads", "1"});
        if (!run.ok) return state.SkipWithError("fjell-bake apply failed");
        apply_s += run.summary["seconds_total"].get<double>();
    }
    state.counters["of_a_bake"] =
        apply_s / static_cast<double>(state.iterations()) / whole.summary["seconds_total"].get<double>();
    state.counters["kept_MB"] = run.summary["kept_bytes"].get<double>() / 1e6;
    state.counters["resident_MB"] = run.resident_mb();
}

// More samples than the memory holds. They are smooth, so that making them does not take most of the time; rates are
// without it.
void larger_than_memory(benchmark::State& state, const char* memory_mb) {
    std::filesystem::create_directories(folder);
    const std::string recipe = folder + "/plain.json";
    std::ofstream(recipe)
        << R"({"columns": 16385, "rows": 16385, "spacing_m": 15, "gullies": 0, "octaves": 1, "warp": 0})";
    for (auto _ : state) {
        const ProgramRun run = run_bake({recipe, "-o", folder + "/large.fjell", "--memory", memory_mb});
        if (!run.ok) return state.SkipWithError("fjell-bake failed");
        state.counters["resident_MB"] = run.resident_mb();
        state.counters["file_MB"] = run.summary["file_bytes"].get<double>() / 1e6;
        const double read = run.summary["seconds_read"], all = run.summary["seconds_total"];
        state.counters["samples/s_after_reading"] = 16385.0 * 16385 / (all - read);
    }
    std::filesystem::remove(folder + "/large.fjell");
}

void verify(benchmark::State& state) {
    const io::LoadedPack pack = io::load_pack(bake_once(0), io::LoadTerrain::yes);
    for (auto _ : state) benchmark::DoNotOptimize(baker::verify(pack.terrain, nullptr));
    rate(state);
}

} // namespace

int main(int argc, char** argv) {
    const auto declare = [](const std::string& name, auto run) {
        benchmark::RegisterBenchmark(name.c_str(), run)->Unit(benchmark::kMillisecond)->UseRealTime();
    };
    declare("copy/mountains-2049/floats", copy);
    declare("errors/mountains-2049/max", [](auto& s) { errors(s, fjell::ErrorEstimate::max, false); });
    declare("errors/mountains-2049/midpoint", [](auto& s) { errors(s, fjell::ErrorEstimate::midpoint, false); });
    declare("errors/mountains-2049/max-and-pages", [](auto& s) { errors(s, fjell::ErrorEstimate::max, true); });
    declare("bake/mountains-2049/1-thread", [](auto& s) { whole_bake(s, 1); });
    declare("bake/mountains-2049/2-threads", [](auto& s) { whole_bake(s, 2); });
    declare("program/mountains-4097-tiled/1-thread", [](auto& s) { program(s, "", 1); });
    declare("program/mountains-4097-tiled/2-threads", [](auto& s) { program(s, "", 2); });
    declare("program/mountains-4097-tiled/1-thread-in-files", [](auto& s) {
        program(s, "", 1, {"--checkpoint", "5"});
    });
    for (const char* const texel : {"half", "quarter"})
        declare("program/mountains-4097-tiled/horizons-" + std::string(texel), [=](auto& s) {
            program(s, "", 1, {"--horizons", texel});
        });
    declare("program/mountains-4097-tiled/layers", [](auto& s) {
        program(s, "", 1, {"--layers", FJELL_SOURCE_DIR "/content/materials/splat/alpine.json"});
    });
    declare("program/mountains-4097-tiled-deflate/1-thread", [](auto& s) { program(s, "-deflate", 1); });
    declare("apply/mountains-4097/crater", apply);
    declare("program/plain-16385/256-MB", [](auto& s) { larger_than_memory(s, "256"); });
    declare("load/mountains-2049/whole", load);
    declare("decode/mountains-2049/planar", [](auto& s) { decode(s, PageOrder::planar); });
    declare("decode/mountains-2049/hz", [](auto& s) { decode(s, PageOrder::hierarchical_z); });
    declare("decode/mountains-2049/linear", [](auto& s) { decode(s, PageOrder::linear); });
    declare("verify/mountains-2049/all-cores", verify);
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
