// Streaming: what a frame spends on it, and what the disk has to give.
//
// Names: stream/scene/what. frame/C: a flight of C cells a frame at 60 frames a second over the mountains of
// content/terrain with a ninth of their pages' slots; the client answers within a frame, so it is our work that is
// measured, not the disk's. soak, first_picture, teleport: with the real reader from the file, its cache dropped where
// that is said (mincore() tells how much of the file was still in memory: the counter `cached`). object:
// io::LiveTerrain beside the parts that it is made of. size/S/T: an update's cost by slots and tiles. memory: by pool,
// with profiles/laptop.toml's budgets.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "baker/synth/synth.h"
#include "fjell/cut.h"
#include "fjell/io/live_terrain.h"
#include "fjell/io/load.h"
#include "fjell/io/stream_reader.h"
#include "fjell/recursive.h"
#include "fjell/stream.h"
#include "support/dem.h"

#include "shared/terrain_data.h"
#include "stream_engine.h"

namespace {

using namespace fjell;
using namespace fjell::bench;

void frame(benchmark::State& state, double cells, bool rests = false) {
    Engine e(mountains(PageOrder::planar), 610, {});
    CutSettings settings;
    settings.max_error_px = 4;
    StreamSettings stream_settings;
    StreamReport stream;
    CutReport report;
    const double cell = e.terrain.header().spacing_m[0];
    View view = view_at(e.terrain, 0.2, 0.7, 3500);
    for (int i = 0; i < 2000; ++i) { // to rest
        stream_settings.now_s += 1.0 / 60;
        require(update_stream(e.stream, {&view, 1}, settings, stream_settings, stream));
        require(update_cut(e.cut, {&view, 1}, settings, report));
        e.serve(64);
    }
    std::vector<double> stream_us, cut_us, prepare_us;
    double pages = 0, converged = 0, removed = 0;
    for (auto _ : state) {
        const int frames = 1500;
        for (int i = 0; i < frames; ++i) {
            if (!rests) view.eye_m = view.eye_m + Vec3{0.8, 0, -0.6} * (cells * cell);
            stream_settings.now_s += 1.0 / 60;
            auto start = Clock::now();
            require(update_stream(e.stream, {&view, 1}, settings, stream_settings, stream));
            stream_us.push_back(us_since(start));
            start = Clock::now();
            require(update_cut(e.cut, {&view, 1}, settings, report));
            cut_us.push_back(us_since(start));
            prepare_us.push_back(report.prepare_us);
            pages += stream.pages_inserted;
            converged += stream.converged;
            for (const PageArrival& a : stream_page_arrivals(e.stream)) removed += a.event == PageEvent::removed;
            e.serve(64);
        }
        state.counters["converged"] = converged / frames;
        state.counters["pages_a_frame"] = pages / frames;
        state.counters["removed_a_frame"] = removed / frames;
        state.counters["slots_used"] = stream.page_slots.used;
        state.counters["missing_px"] = stream.missing_px;
    }
    state.counters["stream_us_p50"] = rank(stream_us, 0.5);
    state.counters["stream_us_p99"] = rank(stream_us, 0.99);
    state.counters["stream_us_max"] = rank(stream_us, 1);
    state.counters["cut_us_p50"] = rank(cut_us, 0.5);
    state.counters["cut_us_p99"] = rank(cut_us, 0.99);
    state.counters["prepare_us_p99"] = rank(prepare_us, 0.99);
}

// --- with the real reader

// Share of the file that the system holds in memory.
double cached(const std::string& path) {
    const std::size_t bytes = std::filesystem::file_size(path), page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    void* const at = mmap(nullptr, bytes, PROT_READ, MAP_SHARED, fd, 0);
    std::vector<unsigned char> in((bytes + page - 1) / page);
    if (at == MAP_FAILED || mincore(at, bytes, in.data()) != 0) std::abort();
    munmap(at, bytes);
    close(fd);
    return static_cast<double>(std::count_if(in.begin(), in.end(), [](unsigned char c) { return c & 1; })) /
           static_cast<double>(in.size());
}
void drop(const std::string& path) {
    io::PackFile(path).drop_cache();
}

struct Disk {
    const char* name;
    io::StreamReaderOptions options;
};
constexpr Disk disks[] = {{"as_is", {}}, {"ssd", {500e6, 0.1e-3}}, {"hard_disk", {150e6, 8e-3}}};

constexpr double kib = 1024, mib = 1024 * 1024;
std::uint64_t map_total(const PackHeader& h) {
    std::uint64_t bytes = 0;
    for (std::uint32_t mip = 0; mip < mip_count(h.normal_log2); ++mip)
        bytes += chunk_raw_bytes(h, {ChunkKind::normal, 0, mip}) * h.tiles_x * h.tiles_y;
    for (std::uint32_t mip = 0; mip < mip_count(h.colour_log2); ++mip)
        bytes += chunk_raw_bytes(h, {ChunkKind::colour, 0, mip}) * h.tiles_x * h.tiles_y;
    return bytes;
}

void soak(benchmark::State& state) {
    const std::string path = mountains(PageOrder::planar);
    StreamBudget budget;
    {
        const io::PackFile file(path);
        budget.map_bytes = map_total(file.pack().header) / 10;
        budget.tail_log2 = 4;
    }
    FileEngine e(path, 550, budget);
    const io::StreamReader reader(e.stream, e.file);
    e.refine.max_error_px = 4;
    e.refine.max_work = 4000; // what a frame may do, teleports or not
    View view = view_at(e.terrain, 0.1, 0.9, 3500);
    (void)e.rest(view, false);
    const double cell = e.terrain.header().spacing_m[0];
    std::vector<double> stream_us, cut_us, stream_worked_us, cut_worked_us, mesh_bytes, map_bytes;
    double converged = 0, effective = 0;
    for (auto _ : state)
        for (int i = 0; i < 10'000; ++i) {
            view.eye_m = view.eye_m + Vec3{0.8, 0, -0.6} * (0.3 * cell);
            if (i % 2500 == 2499) view = view_at(e.terrain, 0.1 + i * 1e-5, 0.9 - i * 4e-5, 3500);
            e.frame(view);
            stream_us.push_back(e.stream_us);
            cut_us.push_back(e.cut_us);
            stream_worked_us.push_back(e.stream_worked_us);
            cut_worked_us.push_back(e.cut_worked_us);
            mesh_bytes.push_back(28.0 * e.updated.vertices_changed + 12.0 * e.updated.triangles_changed);
            map_bytes.push_back(static_cast<double>(e.streamed.map_upload_bytes));
            converged += e.updated.converged;
            effective = std::max(effective, e.updated.error_bound_px < 1e7 ? e.updated.error_bound_px : 0);
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    const auto percentiles = [&](const char* name, const std::vector<double>& v) {
        state.counters[std::string(name) + "_p50"] = rank(v, 0.5);
        state.counters[std::string(name) + "_p99"] = rank(v, 0.99);
        state.counters[std::string(name) + "_p9999"] = rank(v, 0.9999);
        state.counters[std::string(name) + "_max"] = rank(v, 1);
    };
    percentiles("stream_us", stream_us);
    percentiles("cut_us", cut_us);
    percentiles("stream_worked_us", stream_worked_us);
    percentiles("cut_worked_us", cut_worked_us);
    percentiles("mesh_bytes", mesh_bytes);
    percentiles("map_bytes", map_bytes);
    state.counters["converged"] = converged / 10'000;
    state.counters["effective_px_max"] = effective;
    state.counters["pages_read"] = static_cast<double>(e.streamed.pages_read);
    state.counters["mips_read"] = static_cast<double>(e.streamed.mips_read);
}

// The same flight, frame by frame, by update_stream() and update_cut() and by io::LiveTerrain::update(), each over the
// pack in memory with a reader of its own.
void object(benchmark::State& state) {
    const std::string path = mountains(PageOrder::planar);
    const StreamBudget budget{.map_bytes = 64 << 20};
    FileEngine parts(path, 8192, budget);
    const io::StreamReader reader(parts.stream, parts.file);
    parts.refine.max_error_px = 4;
    io::LiveOptions options;
    options.cut = {1u << 20, 1u << 21, 512, 1};
    options.stream = budget;
    options.settings.cut = parts.refine;
    const auto opening = Clock::now();
    io::LiveTerrain whole(path, options);
    state.counters["open_ms"] = us_since(opening) * 1e-3;
    state.counters["memory_MiB"] = static_cast<double>(whole.memory_bytes()) / mib;
    View view = view_at(parts.terrain, 0.2, 0.7, 3500);
    double now_s = 0;
    for (int i = 0; i < 3000 && !(parts.updated.converged && whole.frame().converged); ++i) {
        parts.frame(view);
        (void)whole.update({&view, 1}, now_s += 1.0 / 60);
        std::this_thread::sleep_for(std::chrono::milliseconds(1)); // the readers' turn
    }
    const double cell = parts.terrain.header().spacing_m[0];
    for (auto _ : state) {
        std::vector<double> parts_us, whole_us;
        for (int i = 0; i < 2000; ++i) {
            view.eye_m = view.eye_m + Vec3{0.8, 0, -0.6} * (0.3 * cell);
            const auto time_parts = [&] {
                parts.frame(view);
                parts_us.push_back(parts.stream_us + parts.cut_us);
            };
            const auto time_whole = [&] {
                const auto start = Clock::now();
                (void)whole.update({&view, 1}, now_s += 1.0 / 60);
                whole_us.push_back(us_since(start));
            };
            i % 2 ? time_parts() : time_whole(); // who comes second finds the caches spent
            i % 2 ? time_whole() : time_parts();
            std::this_thread::sleep_for(std::chrono::microseconds(200));
        }
        for (const double q : {0.5, 0.99}) {
            const std::string name = q == 0.5 ? "_p50" : "_p99";
            state.counters["parts_us" + name] = rank(parts_us, q);
            state.counters["object_us" + name] = rank(whole_us, q);
            state.counters["ratio" + name] = rank(whole_us, q) / rank(parts_us, q);
        }
    }
}

void first_picture(benchmark::State& state, const Disk& disk, std::uint32_t threads) {
    const std::string path = mountains(PageOrder::planar);
    for (auto _ : state) {
        drop(path);
        state.counters["cached"] = cached(path);
        const auto start = Clock::now();
        FileEngine e(path, 8192, {.decoders = threads});
        e.refine.max_error_px = 1.5;
        const double opened_s = us_since(start) * 1e-6;
        io::StreamReaderOptions options = disk.options;
        options.threads = threads;
        const io::StreamReader reader(e.stream, e.file, options);
        double complete_s = 0;
        const double converged_s = e.rest(view_at(e.terrain, 0.3, 0.6, 3500), true, &complete_s);
        const io::StreamReaderCounters c = reader.counters();
        state.counters["open_s"] = opened_s;
        state.counters["complete_s"] = opened_s + complete_s;
        state.counters["converged_s"] = opened_s + converged_s;
        state.counters["pages"] = static_cast<double>(c.pages);
        state.counters["mips"] = static_cast<double>(c.mips);
        state.counters["MiB"] = static_cast<double>(c.bytes) / mib;
        state.counters["read_s"] = c.read_s;
        state.counters["provide_s"] = c.provide_s;
    }
}

constexpr double here[] = {0.2, 0.7}, there[] = {0.75, 0.3};

void teleport(benchmark::State& state, PageOrder order, const Disk& disk) {
    const std::string path = mountains(order);
    for (auto _ : state) {
        FileEngine e(path, 8192, {});
        e.refine.max_error_px = 1.5;
        e.settings.texel_px =
            100;               // maps' tails alone: linear order, beside which this stands, is measured without them
        e.settings.pages = 64; // not the frame's limit but the reader's pace
        {
            const io::StreamReader reader(e.stream, e.file);
            (void)e.rest(view_at(e.terrain, here[0], here[1], 3500), true);
        }
        e.file.drop_cache();
        state.counters["cached"] = cached(path);
        const std::uint64_t pages = e.streamed.pages_read, bytes = e.streamed.bytes_read;
        state.counters["held"] = static_cast<double>(pages);
        state.counters["all"] = e.terrain.page_count();
        const io::StreamReader reader(e.stream, e.file, disk.options);
        state.counters["seconds"] = e.rest(view_at(e.terrain, there[0], there[1], 3500), true);
        state.counters["pages"] = static_cast<double>(e.streamed.pages_read - pages);
        state.counters["KiB"] = static_cast<double>(e.streamed.bytes_read - bytes) / kib;
        state.counters["read_s"] = reader.counters().read_s;
    }
}

// Pages of linear order that hold any vertex of what the view wants: tile and page.
std::set<std::uint32_t> linear_pages(const Terrain& t, const View& view, double error_px) {
    const RecursiveBudget budget{1u << 21, 1u << 24};
    const std::size_t bytes = recursive_bytes(t, budget);
    const io::AlignedMemory memory = io::allocate(bytes);
    RecursiveMethod method;
    require(create_recursive(t, budget, {memory.get(), bytes}, method));
    RefineSettings settings;
    settings.max_error_px = error_px;
    settings.cull = false;
    FrameReport report;
    require(update_recursive(method, view, settings, report));
    if (!report.converged) std::abort();
    const MeshView mesh = recursive_mesh(method);
    const std::int32_t side = data_of(t).tree.side();
    std::set<std::uint32_t> pages;
    for (const std::uint32_t index : mesh.indices) {
        const MeshVertex& v = mesh.vertices[index];
        if (v.column % side == 0 && v.row % side == 0) continue; // a tile's corner: always there
        // A vertex on a border is stored in both tiles.
        for (std::int32_t ty = std::max(v.row - 1, 0) / side;
             ty <= std::min<std::int32_t>(v.row / side, data_of(t).tree.tiles_y - 1); ++ty)
            for (std::int32_t tx = std::max(v.column - 1, 0) / side;
                 tx <= std::min<std::int32_t>(v.column / side, data_of(t).tree.tiles_x - 1); ++tx) {
                const auto place = static_cast<std::uint32_t>((v.row - ty * side) * (side + 1) + v.column - tx * side);
                pages.insert(static_cast<std::uint32_t>(ty * data_of(t).tree.tiles_x + tx) * t.pages_per_tile() +
                             place / max_page_vertices);
            }
    }
    return pages;
}

// Linear order cannot be streamed by the cut, whose coarse vertices lie in all pages. This reads and decodes what a
// loader that knew in advance would have to: the pages of the target there that the target here does not hold, in the
// file's order. A slow disk's time is added by its formula.
void teleport_linear(benchmark::State& state) {
    const std::string path = mountains(PageOrder::linear);
    for (auto _ : state) {
        std::vector<std::uint32_t> wanted;
        std::uint32_t per_tile = 0;
        {
            const io::LoadedPack full = io::load_pack(path, io::LoadTerrain::yes);
            const Terrain& t = full.terrain;
            per_tile = t.pages_per_tile();
            const auto before = linear_pages(t, view_at(t, here[0], here[1], 3500), 1.5),
                       after = linear_pages(t, view_at(t, there[0], there[1], 3500), 1.5);
            std::set_difference(after.begin(), after.end(), before.begin(), before.end(), std::back_inserter(wanted));
            state.counters["held"] = static_cast<double>(before.size());
            state.counters["from_nothing"] = static_cast<double>(after.size());
            state.counters["all"] = t.page_count();
        }
        const io::PackFile file(path);
        file.drop_cache();
        state.counters["cached"] = cached(path);
        const auto start = Clock::now();
        std::vector<std::byte> stored, raw;
        double bytes = 0;
        for (const std::uint32_t page : wanted) {
            const ChunkId id{ChunkKind::geometry, page / per_tile, page % per_tile};
            const ChunkEntry entry = file.pack().entry(chunk_index(file.pack().header, id));
            stored.resize(entry.stored_bytes);
            raw.resize(entry.raw_bytes);
            if (file.read(entry.offset, stored) != 0) std::abort();
            require(decode_chunk(entry, stored, raw));
            bytes += entry.stored_bytes;
        }
        const double seconds = us_since(start) * 1e-6;
        state.counters["pages"] = static_cast<double>(wanted.size());
        state.counters["KiB"] = bytes / kib;
        state.counters["seconds_as_is"] = seconds;
        for (const Disk& disk : {disks[1], disks[2]})
            state.counters[std::string("seconds_") + disk.name] =
                seconds + static_cast<double>(wanted.size()) * disk.options.latency_s +
                bytes / disk.options.bytes_per_s;
    }
}

// --- by size

// Rough ground, so that much is wanted.
std::string rough(std::int32_t columns, std::int32_t rows, int tile_log2) {
    const std::string path = std::string(FJELL_BENCH_DIR) + "/stream-rough-" + std::to_string(columns) + "x" +
                             std::to_string(rows) + "-" + std::to_string(tile_log2) + "-" +
                             std::to_string(pack_layout_hash) + ".fjell";
    if (std::filesystem::exists(path)) return path;
    std::filesystem::create_directories(FJELL_BENCH_DIR);
    baker::Dem dem;
    dem.columns = columns, dem.rows = rows;
    dem.spacing_m[0] = dem.spacing_m[1] = 30;
    for (std::int32_t y = 0; y < rows; ++y)
        for (std::int32_t x = 0; x < columns; ++x)
            dem.heights_m.push_back(static_cast<float>(400 * std::sin(x * 0.011) * std::cos(y * 0.013) +
                                                       40 * std::sin(x * 0.31) * std::sin(y * 0.27) +
                                                       static_cast<double>((x * 2654435761u ^ y * 40503u) >> 8 & 7)));
    baker::BakeOptions options;
    options.tile_log2 = tile_log2;
    options.max_texture_log2 = 6;
    (void)baker::bake(std::move(dem), options, path);
    return path;
}

// A flight with too few slots for it, all of which are in use, and 64 answers a frame.
void by_size(benchmark::State& state, const std::string& path, std::uint32_t slots, double error_px, double cells) {
    Engine e(path, slots, {}, false); // a cut's own capacities would raise the threshold before the slots are full
    CutSettings settings;
    settings.max_error_px = error_px;
    StreamSettings stream_settings;
    StreamReport stream;
    View view = view_at(e.terrain, 0.2, 0.4, 1500);
    view.eye_m.z = 0.4 * e.terrain.z_m(data_of(e.terrain).tree.rows() - 1);
    std::vector<double> us;
    const auto frame = [&] {
        stream_settings.now_s += 1.0 / 60;
        require(update_stream(e.stream, {&view, 1}, settings, stream_settings, stream));
        us.push_back(stream.update_us);
        e.serve(64);
    };
    for (int i = 0; i < 1500; ++i) frame();
    us.clear();
    for (auto _ : state)
        for (int i = 0; i < 500; ++i) {
            view.eye_m = view.eye_m + Vec3{0.8, 0, 0.1} * (cells * e.terrain.header().spacing_m[0]);
            frame();
        }
    state.counters["tiles"] = e.terrain.tile_count();
    state.counters["pages"] = e.terrain.page_count();
    state.counters["slots_used"] = stream.page_slots.used;
    state.counters["pages_wanted"] = stream.pages_wanted;
    state.counters["stream_us_p50"] = rank(us, 0.5);
    state.counters["stream_us_p99"] = rank(us, 0.99);
    state.counters["stream_us_max"] = rank(us, 1);
}

void memory(benchmark::State& state) {
    const io::PackFile file(mountains(PageOrder::planar));
    const PackHeader& h = file.pack().header;
    const StreamBudget budget;
    StreamBudget one = budget;
    one.page_requests = one.map_requests = 1;
    for (auto _ : state) {
        const std::uint32_t slots = 8192;
        const std::size_t bytes = terrain_bytes(h, {slots});
        const io::AlignedMemory memory = io::allocate(bytes);
        Terrain t;
        require(create_terrain(file.pack(), file.corners(), {slots}, {memory.get(), bytes}, t));
        const double records = 4.0 * data_of(t).page_capacity * data_of(t).slot_count,
                     table = static_cast<double>(sizeof(PageEntry)) * t.page_count();
        const double stream = static_cast<double>(stream_bytes(file.pack(), t, budget)),
                     least = static_cast<double>(stream_bytes(file.pack(), t, one));
        state.counters["terrain_records_MiB"] = records / mib;
        state.counters["page_table_KiB"] = table / kib;
        state.counters["terrain_rest_KiB"] = (static_cast<double>(bytes) - records - table) / kib;
        state.counters["cut_MiB"] = static_cast<double>(cut_bytes(t, {524288, 1048576, 512, 1})) / mib;
        state.counters["stream_one_request_each_KiB"] = least / kib;
        state.counters["stream_requests_KiB"] = (stream - least) / kib;
        state.counters["directory_KiB"] = static_cast<double>(h.directory_count * sizeof(ChunkEntry)) / kib;
        state.counters["normal_maps_gpu_MiB"] =
            static_cast<double>(map_layer_bytes(map_layers(h, budget, MapKind::normal), MapKind::normal)) / mib;
        state.counters["colour_maps_gpu_MiB"] =
            static_cast<double>(map_layer_bytes(map_layers(h, budget, MapKind::colour), MapKind::colour)) / mib;
    }
}

} // namespace

BENCHMARK_CAPTURE(frame, rest, 0, true)
    ->Name("stream/mountains/frame/rest")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frame, walk, 0.25)->Name("stream/mountains/frame/0.25")->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(frame, drive, 1)->Name("stream/mountains/frame/1")->Iterations(1)->Unit(benchmark::kMillisecond);

BENCHMARK(soak)->Name("stream/mountains/soak")->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(object)->Name("stream/mountains/object")->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(first_picture, as_is, disks[0], 1)
    ->Name("stream/mountains/first_picture/as_is")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(first_picture, as_is_2_threads, disks[0], 2)
    ->Name("stream/mountains/first_picture/as_is_2_threads")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(first_picture, ssd, disks[1], 1)
    ->Name("stream/mountains/first_picture/ssd")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(first_picture, hard_disk, disks[2], 1)
    ->Name("stream/mountains/first_picture/hard_disk")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(teleport, hz, PageOrder::hierarchical_z, disks[0])
    ->Name("stream/mountains/teleport/hz/as_is")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(teleport, planar, PageOrder::planar, disks[0])
    ->Name("stream/mountains/teleport/planar/as_is")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(teleport, hz_ssd, PageOrder::hierarchical_z, disks[1])
    ->Name("stream/mountains/teleport/hz/ssd")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(teleport, planar_ssd, PageOrder::planar, disks[1])
    ->Name("stream/mountains/teleport/planar/ssd")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(teleport, hz_hard_disk, PageOrder::hierarchical_z, disks[2])
    ->Name("stream/mountains/teleport/hz/hard_disk")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(teleport, planar_hard_disk, PageOrder::planar, disks[2])
    ->Name("stream/mountains/teleport/planar/hard_disk")
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(teleport_linear)->Name("stream/mountains/teleport/linear")->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(memory)->Name("stream/mountains/memory")->Iterations(1)->Unit(benchmark::kMillisecond);

namespace {
void slots_8192(benchmark::State& state) {
    by_size(state, rough(8193, 4097, 9), 8192, 0.01, 1);
}
void slots_1024(benchmark::State& state) {
    by_size(state, rough(8193, 4097, 9), 1024, 0.01, 1);
}
void tiles_2048(benchmark::State& state) {
    by_size(state, rough(4097, 2049, 6), 3000, 1, 1);
}
} // namespace
BENCHMARK(slots_1024)->Name("stream/rough/size/1024/128")->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(slots_8192)->Name("stream/rough/size/8192/128")->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(tiles_2048)->Name("stream/rough/size/3000/2048")->Iterations(1)->Unit(benchmark::kMillisecond);

BENCHMARK_MAIN();
