// Recordings: any text is refused or read, and what was read is flown. Whatever views and settings it names, each is
// refused or leaves a cut that holds every promise of cut/state.h.
#include <cstdint>
#include <string_view>

#include "fly/record.h"
#include "host/failure.h"
#include "input.h"
#include "support/cut_scene.h"

namespace {

using namespace fjell;
using namespace fjell::test;
using fuzz::must;

void repeat(const fly::Recording& recording) {
    static const host::LoadedPack pack = [] {
        Random random(1);
        return rich_terrain(random, 40, 4);
    }();
    Cut cut(pack.terrain, ample_cut(pack.terrain, 3));
    std::size_t left = 12; // frames; more only take longer
    for (const fly::RecordedFrame& f : recording.frames) {
        if (left-- == 0) break;
        CutReport report;
        const Status done = (f.rebuild ? rebuild_cut : update_cut)(cut.cut, f.views, f.settings, report);
        if (!done.ok()) continue;
        must(f.rebuild || report.items <= f.settings.items, "a frame keeps to its items");
        must(check_cut(cut).empty(), "a cut is whole after any frame");
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        repeat(fly::parse_recording({reinterpret_cast<const char*>(data), size}, "fuzz"));
    } catch (const host::Failure&) { // said what is wrong
    }
    return 0;
}
