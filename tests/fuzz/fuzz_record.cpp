// Recordings: any text is refused or read, and what was read is flown. Whatever views,
// settings and pages it names, each is
// refused or leaves a cut that holds every promise of cut/state.h.
#include <cstdint>
#include <string_view>

#include "fjell/io/failure.h"
#include "input.h"
#include "session/record.h"
#include "support/cut_scene.h"

namespace {

using namespace fjell;
using namespace fjell::test;
using fuzz::must;

// One that is loaded whole, one whose pages come and go: 2 x 1 tiles of 6 pages.
const io::LoadedPack& whole_pack() {
    static const io::LoadedPack pack = [] {
        Random random(1);
        return rich_terrain(random, 40, 4);
    }();
    return pack;
}
const io::LoadedPack& paged_pack() {
    static const io::LoadedPack pack = [] {
        Random random(2);
        return bake_and_load(random_dem(random, 257, 129, Shape::fractal), small_bake(7));
    }();
    return pack;
}

void repeat(const session::Recording& recording) {
    const bool paged = recording.page_slots != 0;
    const io::LoadedPack& pack = paged ? paged_pack() : whole_pack();
    PagedTerrain some(paged_pack().pack, {std::min(recording.page_slots, 64u)});
    Cut cut(paged ? some.terrain : pack.terrain, ample_cut(pack.terrain, 3));
    std::size_t left = 12; // frames; more only take longer
    for (const session::RecordedFrame& f : recording.frames) {
        if (left-- == 0) break;
        if (paged) (void)session::replay_pages(pack.pack, some.terrain, cut.cut, f);
        CutReport report;
        const Status done = (f.rebuild ? rebuild_cut : update_cut)(cut.cut, f.views, f.settings, report);
        if (!done.ok()) continue;
        must(f.rebuild || report.work <= f.settings.max_work, "a frame keeps to its items");
        must(check_cut(cut).empty(), "a cut is whole after any frame");
    }
}

} // namespace

extern "C" int fuzz_record(const std::uint8_t* data, std::size_t size) {
    try {
        repeat(session::parse_recording({reinterpret_cast<const char*>(data), size}, "fuzz"));
    } catch (const io::Failure&) { // said what is wrong
    }
    return 0;
}
