// invariant 5: a frame of the live cut allocates nothing, takes no lock, enters no kernel, touches no new page
// and throws nothing. Each is proved for 10,000 frames, and each proof is seen to catch one that was planted.
//
// Allocations, locks and exceptions: the functions themselves are interposed. System calls: Syscall User Dispatch turns
// each into a SIGSYS between begin and end (the handler carries it out, so that the program goes on). Page faults: what
// the kernel counts for this thread.
#include <catch2/catch.hpp>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include <dlfcn.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#include "fjell/io/live_terrain.h"
#include "fjell/stream.h"
#include "support/cut_scene.h"
#include "support/patience.h"

namespace {

struct Counts {
    long allocations = 0, locks = 0, exceptions = 0, system_calls = 0, page_faults = 0;
    long last_call = -1; // number of the last system call
};
thread_local bool inside = false;
thread_local Counts counts;

} // namespace

#if defined(FJELL_SANITIZED) || !defined(__x86_64__)
constexpr bool interposed = false;
#else
constexpr bool interposed = true;
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);
void* malloc(std::size_t bytes) {
    counts.allocations += inside;
    return __libc_malloc(bytes);
}
void* calloc(std::size_t count, std::size_t bytes) {
    counts.allocations += inside;
    return __libc_calloc(count, bytes);
}
void* realloc(void* block, std::size_t bytes) {
    counts.allocations += inside;
    return __libc_realloc(block, bytes);
}
void free(void* block) {
    counts.allocations += inside;
    __libc_free(block);
}
void* memalign(std::size_t alignment, std::size_t bytes) {
    counts.allocations += inside;
    return __libc_memalign(alignment, bytes);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) {
    counts.allocations += inside;
    return __libc_memalign(alignment, bytes);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t bytes) {
    counts.allocations += inside;
    *block = __libc_memalign(alignment, bytes);
    return *block == nullptr ? 12 : 0; // ENOMEM
}
int pthread_mutex_lock(pthread_mutex_t* mutex) {
    using Lock = int (*)(pthread_mutex_t*);
    static std::atomic<Lock> next{nullptr};
    counts.locks += inside;
    if (next.load() == nullptr) next.store(reinterpret_cast<Lock>(dlsym(RTLD_NEXT, "pthread_mutex_lock")));
    return next.load()(mutex);
}
[[noreturn]] void __cxa_throw(void* thrown, void* type, void (*destroy)(void*)) {
    using Throw = void (*)(void*, void*, void (*)(void*));
    counts.exceptions += inside;
    inside = false; // what unwinding does is the exception's
    reinterpret_cast<Throw>(dlsym(RTLD_NEXT, "__cxa_throw"))(thrown, type, destroy);
    std::abort();
}
}
#endif

namespace {

#ifdef __x86_64__
volatile char selector = 0; // 0: system calls go through; 1: they come as SIGSYS

void on_system_call(int, siginfo_t* info, void* context) {
    selector = 0;
    ++counts.system_calls;
    counts.last_call = info->si_syscall;
    greg_t* const regs = static_cast<ucontext_t*>(context)->uc_mcontext.gregs;
    register long r10 asm("r10") = regs[REG_R10];
    register long r8 asm("r8") = regs[REG_R8];
    register long r9 asm("r9") = regs[REG_R9];
    long result = info->si_syscall;
    asm volatile("syscall"
                 : "+a"(result)
                 : "D"(regs[REG_RDI]), "S"(regs[REG_RSI]), "d"(regs[REG_RDX]), "r"(r10), "r"(r8), "r"(r9)
                 : "rcx", "r11", "memory");
    regs[REG_RAX] = result;
    // Not watched again before the next begin(): returning from here is a system call itself.
}

// Why system calls cannot be watched, or empty.
std::string watch_system_calls() {
    static std::string why = [] {
        struct sigaction action {};
        action.sa_sigaction = on_system_call;
        action.sa_flags = SA_SIGINFO;
        if (sigaction(SIGSYS, &action, nullptr) != 0) return std::string("no handler for SIGSYS");
        constexpr int set_dispatch = 59; // PR_SET_SYSCALL_USER_DISPATCH, Linux 5.11
        if (prctl(set_dispatch, 1, 0, 0, &selector) != 0)
            return std::string("no Syscall User Dispatch: ") + std::strerror(errno);
        return std::string();
    }();
    return why;
}
#else
char selector = 0;
std::string watch_system_calls() {
    return "only on x86-64";
}
#endif

long faults() {
    rusage use{};
    getrusage(RUSAGE_THREAD, &use);
    return use.ru_minflt + use.ru_majflt;
}

// Runs it and adds what it did to `counts`.
template <typename Work>
void watched(const Work& work) {
    const long before = faults();
    selector = 1;
    inside = true;
    work();
    inside = false;
    selector = 0;
    counts.page_faults += faults() - before;
}

using namespace fjell;
using namespace fjell::test;

// Memory that no thread of the kernel rearranges under us, touched by whoever is given it.
struct PlainBlock {
    explicit PlainBlock(std::size_t bytes) : size((bytes + 4095) / 4096 * 4096) {
        at = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (at == MAP_FAILED) throw std::runtime_error("no memory");
        (void)madvise(at, size, MADV_NOHUGEPAGE);
    }
    ~PlainBlock() { munmap(at, size); }
    PlainBlock(const PlainBlock&) = delete;
    PlainBlock& operator=(const PlainBlock&) = delete;
    [[nodiscard]] std::span<std::byte> span() const { return {static_cast<std::byte*>(at), size}; }
    void* at;
    std::size_t size;
};

struct Seen {
    std::uint32_t exhausted = 0, pages_loaded = 0, pages_released = 0;
    std::uint64_t activations = 0, deactivations = 0, governed = 0, converged = 0, triangles = 0;
};

// Walking and turning, teleports, thresholds, lenses, a second view, item and time limits, pages that come and go.
Seen fly(const io::LoadedPack& pack, std::uint32_t seed, int frames) {
    Random random(seed);
    PlainBlock terrain_memory(terrain_bytes(pack.pack.header, {}));
    Terrain terrain;
    if (!create_terrain(pack.pack, {}, terrain_memory.span(), terrain).ok()) throw std::runtime_error("terrain");
    for (std::uint32_t p = 0; p < terrain.page_count(); ++p)
        (void)load_page(pack.pack, terrain, p / terrain.pages_per_tile(), p % terrain.pages_per_tile());
    CutBudget budget;
    budget.vertices = 20'000;
    budget.segment_triangles = 64;
    budget.triangles = 64 * 1000;
    budget.views = 2;
    PlainBlock cut_memory(cut_bytes(terrain, budget));
    LiveCut cut;
    if (!create_cut(terrain, budget, cut_memory.span(), cut).ok()) throw std::runtime_error("cut");
    Seen seen;
    View views[2] = {random_view(random, terrain), random_view(random, terrain)};
    CutSettings settings;
    std::uint32_t leaving = no_index;
    for (int frame = 0; frame < frames; ++frame) {
        views[0] = moved(random, views[0], terrain.spacing_x_m() * (frame % 500 < 400 ? 0.3 : 8));
        if (frame % 1000 == 999) views[0] = random_view(random, terrain);
        if (frame % 700 == 699) views[1] = random_view(random, terrain);
        if (frame % 250 == 0)
            settings.max_error_px = std::pow(10.0, frame % 1500 < 750 ? uniform(random, 1, 2) : uniform(random, -2, 0));
        settings.hysteresis = frame % 400 < 200 ? 0 : 0.2;
        settings.max_work = frame % 300 < 200 ? 3000 : unlimited_work;
        settings.max_time_us = frame % 600 < 100 ? 50 : 0;
        settings.corner_safe = frame % 2000 >= 1500;
        settings.offscreen_factor = frame % 900 < 450 ? 1 : 6;
        const std::size_t view_count = frame % 300 < 250 ? 1 : 2;
        if (leaving == no_index && frame % 20 == 0)
            leaving = static_cast<std::uint32_t>(pick(random, 0, static_cast<int>(terrain.page_count()) - 1));
        bool released = false;
        CutReport report;
        Status done, asked;
        watched([&] {
            if (leaving != no_index)
                asked = cut_release_page(cut, leaving / terrain.pages_per_tile(), leaving % terrain.pages_per_tile(),
                                         released);
            done = update_cut(cut, {views, view_count}, settings, report);
            seen.triangles += cut_mesh(cut).mesh.tiles.size();
        });
        if (!done.ok() || !asked.ok()) throw std::runtime_error(done.field);
        if (released) {
            (void)unload_page(terrain, leaving / terrain.pages_per_tile(), leaving % terrain.pages_per_tile());
            leaving = no_index;
            ++seen.pages_released;
        }
        for (int n = 0; n < 4; ++n) {
            const auto page = static_cast<std::uint32_t>(pick(random, 0, static_cast<int>(terrain.page_count()) - 1));
            const std::uint32_t missing = terrain.pages_missing();
            (void)load_page(pack.pack, terrain, page / terrain.pages_per_tile(), page % terrain.pages_per_tile());
            seen.pages_loaded += missing - terrain.pages_missing();
        }
        seen.exhausted |= report.exhausted;
        seen.activations += report.activations;
        seen.deactivations += report.deactivations;
        seen.governed += report.threshold_px > report.error_px_requested;
        seen.converged += report.converged;
    }
    return seen;
}

io::LoadedPack purity_scene() {
    Random random(151);
    baker::BakeOptions options = small_bake(7);
    options.max_texture_log2 = 7;
    baker::Dem dem = random_dem(random, 513, 513, Shape::fractal);
    for (float& height : dem.heights_m) height *= 0.05f; // gentle: in steep terrain every page's sphere holds the eye
    return bake_and_load(std::move(dem), options);
}

struct SeenStream {
    std::uint32_t exhausted = 0, failed = 0;
    std::uint64_t pages = 0, removed = 0, mips = 0, withdrawn = 0, converged = 0;
};

// The same with everything streamed, through a third of the slots, by a client that is late and now and then wrong.
SeenStream fly_streamed(const io::LoadedPack& pack, std::uint32_t seed, int frames) {
    Random random(seed);
    const TerrainBudget slots{pack.terrain.page_count() / 3};
    PlainBlock terrain_memory(terrain_bytes(pack.pack.header, slots));
    Terrain terrain;
    if (!create_terrain(pack.pack, slots, terrain_memory.span(), terrain).ok()) throw std::runtime_error("terrain");
    const CutBudget budget{200'000, 400'000, 64, 2};
    PlainBlock cut_memory(cut_bytes(terrain, budget));
    LiveCut cut;
    if (!create_cut(terrain, budget, cut_memory.span(), cut).ok()) throw std::runtime_error("cut");
    const StreamBudget stream_budget{.page_requests = 20, .map_requests = 4, .map_bytes = 250'000, .tail_log2 = 4};
    PlainBlock stream_memory(stream_bytes(pack.pack, terrain, stream_budget));
    Stream stream;
    if (!create_stream(pack.pack, terrain, cut, stream_budget, stream_memory.span(), stream).ok())
        throw std::runtime_error("stream");
    SeenStream seen;
    View views[2] = {random_view(random, terrain), random_view(random, terrain)};
    CutSettings settings;
    StreamSettings stream_settings;
    for (int frame = 0; frame < frames; ++frame) {
        views[0] = moved(random, views[0], terrain.spacing_x_m() * (frame % 500 < 400 ? 0.3 : 8));
        if (frame % 300 == 299) views[0] = random_view(random, terrain);
        if (frame % 700 == 699) views[1] = random_view(random, terrain);
        if (frame % 250 == 0) settings.max_error_px = std::pow(10.0, uniform(random, -1, 1.5));
        if (frame % 2000 == 1999) (void)stream_retry_failed(stream);
        stream_settings.now_s += 1.0 / 60;
        stream_settings.tests = frame % 200 < 20 ? 5 : 1u << 16;
        stream_settings.map_bytes = frame % 400 < 200 ? 100 : 1u << 20;
        stream_settings.pages = frame % 300 < 100 ? 1 : 8;
        const std::size_t view_count = frame % 600 < 500 ? 1 : 2;
        StreamReport report;
        CutReport cut_report;
        Status done, cut_done;
        watched([&] {
            done = update_stream(stream, {views, view_count}, settings, stream_settings, report);
            cut_done = update_cut(cut, {views, view_count}, settings, cut_report);
        });
        if (!done.ok() || !cut_done.ok()) throw std::runtime_error(done.field);
        StreamRequest request;
        for (int n = pick(random, 0, frame % 100 < 50 ? 8 : 2); n > 0 && stream_next_request(stream, request); --n) {
            if (pick(random, 0, 100) == 0)
                (void)stream_fail(stream, request.ticket);
            else
                (void)stream_provide(stream, request.ticket, pack.pack.bytes.subspan(request.offset, request.bytes));
        }
        for (const PageArrival& a : stream_page_arrivals(stream)) seen.removed += a.event == PageEvent::removed;
        seen.pages += report.pages_inserted;
        seen.mips += report.mips_uploaded;
        seen.withdrawn += report.cancelled;
        seen.converged += report.converged;
        seen.exhausted |= report.exhausted;
        seen.failed = report.failed;
    }
    return seen;
}

// The same of a terrain in one object, whose own thread reads: so many frames, and on until it has come far enough.
SeenStream fly_live(const io::LoadedPack& pack, std::uint32_t seed, int frames) {
    Random random(seed);
    io::LiveTerrain terrain(pack.file, "memory",
                            {.page_slots = pack.terrain.page_count() / 3,
                             .cut = {60'000, 120'000, 64, 1},
                             .stream = {.page_requests = 20, .map_requests = 4, .map_bytes = 250'000, .tail_log2 = 4},
                             .reader = {},
                             .settings = {}});
    SeenStream seen;
    View view = random_view(random, terrain.terrain());
    const Patience patience;
    for (int frame = 0; frame < frames || ((seen.pages <= 50 || seen.mips <= 5) && patience.left()); ++frame) {
        view = moved(random, view, terrain.terrain().spacing_x_m() * (frame % 500 < 400 ? 0.3 : 8));
        if (frame % 300 == 299) view = random_view(random, terrain.terrain());
        if (frame % 250 == 0) terrain.settings.cut.max_error_px = std::pow(10.0, uniform(random, -1, 1.5));
        watched([&] {
            (void)terrain.update({&view, 1}, frame / 60.0);
            seen.mips += terrain.take_map_commands().size();
            (void)terrain.tile_maps(MapKind::normal);
            (void)terrain.take_changes();
        });
        seen.pages += terrain.frame().stream.pages_inserted;
        seen.converged += terrain.frame().converged;
        seen.exhausted |= terrain.frame().stream.exhausted | (terrain.frame().short_of.empty() ? 0u : 1u << 31);
    }
    return seen;
}

} // namespace

TEST_CASE("10,000 frames neither allocate, lock, enter the kernel, touch a new page nor throw") {
    if (!interposed) {
        WARN("skipped: a sanitizer has malloc to itself, or this is no x86-64");
        return;
    }
    const std::string blind = watch_system_calls();
    if (!blind.empty()) WARN("skipped: system calls are not watched: " << blind);
    const auto pack = purity_scene();
    (void)fly(pack, 152, 1500); // code and stack are paged in once a process, not once a cut
    counts = {};
    const Seen seen = fly(pack, 153, 10'000);
    const Counts found = counts;
    CHECK(found.allocations == 0);
    CHECK(found.locks == 0);
    CHECK(found.exceptions == 0);
    CAPTURE(found.last_call);
    CHECK(found.system_calls == 0);
    CHECK(found.page_faults == 0);
    // And they had something to do, all of it.
    CHECK(seen.exhausted == (cut_budget_vertices | cut_budget_work | cut_budget_time));
    CAPTURE(seen.activations, seen.deactivations, seen.governed, seen.converged);
    CHECK(seen.activations > 100'000);
    CHECK(seen.deactivations > 100'000);
    CHECK(seen.governed > 200);
    CHECK(seen.converged > 300);
    CHECK(seen.pages_loaded > 100);
    CHECK(seen.pages_released > 100);
    CHECK(seen.triangles > 0);
}

TEST_CASE("10,000 frames of streaming do not either") {
    if (!interposed) {
        WARN("skipped: a sanitizer has malloc to itself, or this is no x86-64");
        return;
    }
    const std::string blind = watch_system_calls();
    if (!blind.empty()) WARN("skipped: system calls are not watched: " << blind);
    const auto pack = purity_scene();
    (void)fly_streamed(pack, 154, 1500);
    counts = {};
    const SeenStream seen = fly_streamed(pack, 155, 10'000);
    const Counts found = counts;
    CHECK(found.allocations == 0);
    CHECK(found.locks == 0);
    CHECK(found.exceptions == 0);
    CAPTURE(found.last_call);
    CHECK(found.system_calls == 0);
    CHECK(found.page_faults == 0);
    CAPTURE(seen.pages, seen.removed, seen.mips, seen.withdrawn, seen.converged, seen.failed);
    CHECK(seen.exhausted ==
          (stream_page_slots | stream_map_bytes | stream_pages | stream_upload | stream_tests | stream_requests));
    CHECK(seen.pages > 200);
    CHECK(seen.removed > 150);
    CHECK(seen.mips > 100);
    CHECK(seen.withdrawn > 3);
    CHECK(seen.converged > 100);
    CHECK(seen.failed > 0);
}

TEST_CASE("10,000 frames of a terrain in one object do not either") {
    if (!interposed) {
        WARN("skipped: a sanitizer has malloc to itself, or this is no x86-64");
        return;
    }
    const std::string blind = watch_system_calls();
    if (!blind.empty()) WARN("skipped: system calls are not watched: " << blind);
    const auto pack = purity_scene();
    (void)fly_live(pack, 156, 1500);
    counts = {};
    const SeenStream seen = fly_live(pack, 157, 10'000);
    CHECK(counts.allocations == 0);
    CHECK(counts.locks == 0);
    CHECK(counts.exceptions == 0);
    CAPTURE(counts.last_call);
    CHECK(counts.system_calls == 0);
    CAPTURE(seen.pages, seen.mips, seen.converged);
    CHECK(seen.pages > 50);
    CHECK(seen.mips > 5);
    CHECK((seen.exhausted >> 31) == 1);
}

TEST_CASE("the watch catches one planted allocation, lock, system call, page fault and exception") {
    if (!interposed) {
        WARN("skipped: a sanitizer has malloc to itself, or this is no x86-64");
        return;
    }
    const std::string blind = watch_system_calls();
    watched([] {}); // paged in
    counts = {};
    watched([] {});
    CHECK((counts.allocations | counts.locks | counts.exceptions | counts.system_calls | counts.page_faults) == 0);

    void* volatile kept = nullptr; // escapes, so that nothing is removed
    for (int way = 0; way < 5; ++way) {
        counts = {};
        watched([&] {
            void* block = nullptr;
            switch (way) {
            case 0: kept = std::malloc(16); break;
            case 1: kept = std::calloc(1, 16); break;
            case 2: kept = ::operator new(16); break;
            case 3: kept = std::aligned_alloc(64, 64); break;
            case 4:
                if (posix_memalign(&block, 64, 64) == 0) kept = block;
                break;
            }
        });
        CAPTURE(way);
        CHECK(counts.allocations == 1);
        counts = {};
        watched([&] { std::free(kept); });
        CHECK(counts.allocations == 1);
    }

    static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
    counts = {};
    watched([] { (void)pthread_mutex_lock(&mutex); });
    CHECK(counts.locks == 1);
    (void)pthread_mutex_unlock(&mutex);

    if (blind.empty()) {
        counts = {};
        long id = 0;
        watched([&] { id = syscall(SYS_getpid); });
        CHECK(counts.system_calls == 1);
        CHECK(counts.last_call == SYS_getpid);
        CHECK(id == getpid()); // and the handler did what was asked
    } else {
        WARN("skipped: system calls are not watched: " << blind);
    }

    const PlainBlock fresh(4096);
    counts = {};
    watched([&] { *static_cast<volatile char*>(fresh.at) = 1; });
    CHECK(counts.page_faults == 1);

    counts = {};
    bool caught = false;
    try {
        watched([] { throw std::runtime_error("planted"); });
    } catch (const std::runtime_error&) {
        caught = true;
    }
    inside = false;
    selector = 0;
    CHECK(caught);
    CHECK(counts.exceptions == 1);
}
