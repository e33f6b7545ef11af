// The real window, driven as by hand. Every case has its own X server, so cases may run side by side.
#include <catch2/catch.hpp>

#include <cmath>
#include <set>

#include "support/editor_window.h"
#include "support/program.h"

using namespace fjell;
using namespace fjell::test;
using nlohmann::json;

namespace {

const TemporaryFolder& packs() {
    static const TemporaryFolder folder;
    static const bool made = [] {
        const Run r = run_in(folder.path, FJELL_BIN_DIR "/fjell-bake " FJELL_SOURCE_DIR
                                                        "/content/terrain/mountains-small.json -o small.fjell --tile 64");
        INFO(r.err);
        REQUIRE(r.code == 0);
        return true;
    }();
    (void)made;
    return folder;
}

bool no_windows() {
    const std::string why = why_no_windows();
    if (!why.empty()) WARN("skipped: " << why);
    return !why.empty();
}

// An editor over the small terrain, in a home of its own.
struct Desk {
    VirtualDisplay display;
    TemporaryFolder home;
    EditorWindow editor;

    explicit Desk(std::vector<std::string> more = {}, std::uint32_t width = 1280, std::uint32_t height = 720)
        : display(1920, 1080), editor(display, home.path, [&] {
              std::vector<std::string> all{packs() / "small.fjell", "--size",
                                           std::to_string(width) + "x" + std::to_string(height)};
              all.insert(all.end(), more.begin(), more.end());
              return all;
          }()) {}
};

Place view_of(const json& state) {
    const json& v = state["interface"]["view_px"];
    return {v[0], v[1], v[2], v[3]};
}

std::size_t colours_in(const gl::Image& image, const Place& p) {
    std::set<std::uint32_t> seen;
    for (auto y = static_cast<std::uint32_t>(p.y); y < static_cast<std::uint32_t>(p.y + p.height); y += 2)
        for (auto x = static_cast<std::uint32_t>(p.x); x < static_cast<std::uint32_t>(p.x + p.width); x += 2) {
            const std::uint8_t* c = image.pixel(x, y);
            seen.insert(c[0] | c[1] << 8 | c[2] << 16);
        }
    return seen.size();
}

// Share of the pixels of a place that differ by more than a little.
double changed(const gl::Image& a, const gl::Image& b, const Place& p) {
    std::size_t differ = 0, all = 0;
    for (auto y = static_cast<std::uint32_t>(p.y); y < static_cast<std::uint32_t>(p.y + p.height); ++y)
        for (auto x = static_cast<std::uint32_t>(p.x); x < static_cast<std::uint32_t>(p.x + p.width); ++x, ++all) {
            const std::uint8_t *c = a.pixel(x, y), *d = b.pixel(x, y);
            differ += std::abs(c[0] - d[0]) + std::abs(c[1] - d[1]) + std::abs(c[2] - d[2]) > 24;
        }
    return static_cast<double>(differ) / static_cast<double>(all);
}

} // namespace

TEST_CASE("dragging the threshold's slider coarsens the mesh at once, as one step that can be undone") {
    if (no_windows()) return;
    Desk desk;
    const json before = desk.editor.until("a converged mesh", [](const json& s) { return s["measures"]["converged"] == true; });
    const gl::Image fine = desk.display.picture();
    CHECK(colours_in(fine, view_of(before)) > 500); // a landscape, not a blank
    desk.editor.drag("refine.error_px", 0.42, 0.8);
    const json after = desk.editor.until("a coarser mesh", [&](const json& s) {
        return s["profile"]["refine.error_px"] > 4 && s["measures"]["converged"] == true &&
               s["measures"]["vertices"] < before["measures"]["vertices"];
    });
    CHECK(after["document"]["unsaved"] == true);
    CHECK(after["document"]["undo"] == 1);
    CHECK(after["measures"]["error_px_asked"] == after["profile"]["refine.error_px"]);
    CHECK(changed(fine, desk.display.picture(), view_of(after)) > 0.01);
    desk.editor.key("ctrl+z");
    const json back = desk.editor.until("the old mesh", [&](const json& s) {
        return s["document"]["undo"] == 0 && s["measures"]["converged"] == true &&
               s["measures"]["vertices"] == before["measures"]["vertices"];
    });
    CHECK(back["profile"] == before["profile"]);
    CHECK(back["document"]["unsaved"] == false);
}
