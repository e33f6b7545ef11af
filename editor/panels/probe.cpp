// What the probe knows, in the picture's corner, and where it was measured: drawn over the picture, and no window, so
// that the mouse goes through it.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "editor/number_text.h"
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

constexpr ImU32 paper = IM_COL32(12, 14, 18, 215), mark_colour = IM_COL32(255, 214, 102, 255),
                shadow = IM_COL32(0, 0, 0, 200);

// Lines of text from the top down, each label with its value beside it.
class Rows {
public:
    Rows(ImDrawList& list, ImVec2 at, float values) : list_(list), at_(at), values_(values) {}
    void row(const char* label, const char* value, ImU32 colour = IM_COL32_WHITE) {
        list_.AddText(at_, ui::quiet, label);
        list_.AddText({at_.x + values_, at_.y}, colour, value);
        at_.y += 1.3F * ImGui::GetFontSize();
    }
    void line(const char* text, float wrap_width = 0) {
        list_.AddText(nullptr, 0, at_, ui::quiet, text, nullptr, wrap_width);
        at_.y += 1.3F * ImGui::GetFontSize();
    }
    [[nodiscard]] float y() const { return at_.y; }
    void skip(float height) { at_.y += height; }

private:
    ImDrawList& list_;
    ImVec2 at_;
    float values_;
};

void ground_rows(const State& state, Rows& rows) {
    char text[96];
    const ProbedGround& g = *state.probe.ground;
    rows.row("Place", place_text(g.position_m.x, g.position_m.y, g.position_m.z).text);
    std::snprintf(text, sizeof text, "%.20s m away", metre_text(g.distance_m).text);
    rows.row("Distance", text);
    std::snprintf(text, sizeof text, "%.0f deg", g.slope_rad * 180 / std::numbers::pi);
    rows.row("Slope", text);
    std::snprintf(text, sizeof text, "%d, %d: tile %u, %u, page %u", g.sample.x, g.sample.y, g.tile_x, g.tile_y,
                  g.page);
    rows.row("Sample", text);
    if (g.finest)
        std::snprintf(text, sizeof text, "full resolution");
    else
        std::snprintf(text, sizeof text, "within %.3g m: pages missing", g.error_m);
    rows.row("Ground", text, g.finest ? IM_COL32_WHITE : ui::warning_colour);
    if (!g.mesh) return rows.row("Mesh", state.probe.looking ? "..." : "nothing is drawn here");
    std::snprintf(text, sizeof text, "level %d, off by %.2f m: %.2f px", g.mesh->level,
                  std::abs(g.mesh->height_m - g.position_m.y), g.mesh->error_px);
    rows.row("Mesh", text);
}

void draw_profile(const HeightProfile& p, const ui::Rect& at, ImDrawList& list) {
    const double most = static_cast<double>(p.highest_m), least = static_cast<double>(p.lowest_m);
    const double range = std::max(most - least, 1e-3);
    std::array<ImVec2, HeightProfile::samples> points;
    for (std::size_t i = 0; i < p.samples; ++i) {
        const auto share = static_cast<float>((static_cast<double>(p.height_m[i]) - least) / range);
        points[i] = {at.x + at.width * static_cast<float>(i) / (HeightProfile::samples - 1),
                     at.y + at.height * (1 - share)};
    }
    list.AddRectFilled({at.x, at.y}, {at.x + at.width, at.y + at.height}, IM_COL32(28, 31, 37, 255));
    for (std::size_t i = 1; i < p.samples; ++i)
        list.AddQuadFilled({points[i - 1].x, at.y + at.height}, points[i - 1], points[i],
                           {points[i].x, at.y + at.height}, IM_COL32(255, 214, 102, 60));
    list.AddPolyline(points.data(), static_cast<int>(p.samples), mark_colour, 0, 1.5F);
}

void profile_rows(const Probe& probe, Rows& rows) {
    char text[96];
    const HeightProfile& p = probe.profile;
    const Vec3 &from = probe.mark_m[0], &to = probe.mark_m[1];
    const double rise_m = to.y - from.y;
    std::snprintf(text, sizeof text, "%.20s m, %.20s m %s", metre_text(p.length_m).text,
                  metre_text(std::abs(rise_m)).text, rise_m < 0 ? "down" : "up");
    rows.row("1 to 2", text, mark_colour);
    std::snprintf(text, sizeof text, "%.20s to %.20s m", metre_text(static_cast<double>(p.lowest_m)).text,
                  metre_text(static_cast<double>(p.highest_m)).text);
    rows.row("Heights", text);
}

// Positions in the picture, in pixels of the window.
struct Picture {
    const View& view;
    const ui::Rect& rect;
    [[nodiscard]] std::optional<ImVec2> at(const Vec3& position_m) const {
        const auto place = place_in(view, position_m);
        if (!place) return {};
        return ImVec2{rect.x + static_cast<float>((*place)[0]) * rect.width,
                      rect.y + static_cast<float>((*place)[1]) * rect.height};
    }
};

// The line over the ground from mark to mark, whether something stands before it or not, and the marks.
void draw_marks(const Probe& probe, const Picture& picture, const ui::Rect& plate, ImDrawList& list) {
    const float em = ImGui::GetFontSize();
    if (probe.marks == 2) {
        const HeightProfile& p = probe.profile;
        const Vec3 &from = probe.mark_m[0], &to = probe.mark_m[1];
        std::optional<ImVec2> before;
        for (std::size_t i = 0; i < p.samples; ++i) {
            const double t = static_cast<double>(i) / (HeightProfile::samples - 1);
            const auto now = picture.at(
                {from.x + t * (to.x - from.x), static_cast<double>(p.height_m[i]), from.z + t * (to.z - from.z)});
            if (before && now) list.AddLine(*before, *now, mark_colour, std::max(1.0F, em / 8));
            before = now;
        }
    }
    for (std::size_t i = 0; i < probe.marks; ++i) {
        const auto at = picture.at(probe.mark_m[i]);
        if (!at) continue;
        list.AddCircleFilled(*at, 0.35F * em, shadow);
        list.AddCircleFilled(*at, 0.25F * em, mark_colour);
        if (at->x < plate.x + plate.width && at->y < plate.y + plate.height) continue; // which covers its number
        const char name[2] = {static_cast<char>('1' + i), 0};
        list.AddText({at->x + 0.5F * em, at->y - 1.1F * em}, mark_colour, name);
    }
}

const char* probe_help(const Probe& probe) {
    return probe.marks == 1 ? "Click: the second place. Esc or I: end."
                            : "Click: mark a place, then another. Esc or I: end.";
}

struct ProbePlate {
    ui::Rect rect;
    float text_width = 0, graph = 0; // graph: 0 without one
};

ProbePlate probe_plate(const Probe& probe, const ui::Rect& view) {
    const float em = ImGui::GetFontSize();
    const bool both = probe.marks == 2;
    ProbePlate p;
    p.graph = both ? 5 * em : 0;
    p.rect = {view.x + 0.6F * em, view.y + 0.6F * em, std::min(26 * em, view.width - 1.2F * em), 0};
    p.text_width = p.rect.width - 1.2F * em;
    const float help = ImGui::CalcTextSize(probe_help(probe), nullptr, false, p.text_width).y;
    p.rect.height = (1.3F * (both ? 8 : 6) + 1.2F) * em + p.graph + help;
    return p;
}

} // namespace

ui::Rect beside_probe(const State& state, const ui::Rect& view) {
    if (!state.probe.on || !state.scene.open()) return view;
    const ui::Rect taken = probe_plate(state.probe, view).rect;
    const float right = taken.x + taken.width, low = taken.y + taken.height;
    if (view.x + view.width - right >= 30 * ImGui::GetFontSize())
        return {right, view.y, view.x + view.width - right, view.height};
    return {view.x, low, view.width, std::max(view.y + view.height - low, 0.0F)};
}

void draw_probe(const State& state, const ui::Rect& view) {
    const Probe& probe = state.probe;
    if (!probe.on || !state.scene.open()) return;
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    list.PushClipRect({view.x, view.y}, {view.x + view.width, view.y + view.height});
    const float em = ImGui::GetFontSize();
    const Picture picture{state.eye.view, view};
    const ProbePlate plate = probe_plate(probe, view);
    draw_marks(probe, picture, plate.rect, list);
    if (probe.ground)
        if (const auto at = picture.at(probe.ground->position_m)) {
            list.AddCircle(*at, 0.4F * em, shadow, 0, 3);
            list.AddCircle(*at, 0.4F * em, IM_COL32_WHITE, 0, 1.5F);
        }
    const ImVec2 from{plate.rect.x, plate.rect.y};
    list.AddRectFilled(from, {from.x + plate.rect.width, from.y + plate.rect.height}, paper, 0.25F * em);
    Rows rows(list, {from.x + 0.6F * em, from.y + 0.5F * em}, 5.4F * em);
    if (probe.ground) {
        ground_rows(state, rows);
    } else {
        rows.row("Place", probe.pointer ? "no ground here" : "move the pointer over the ground");
        for (int i = 0; i < 5; ++i) rows.line("");
    }
    if (probe.marks == 2) {
        profile_rows(probe, rows);
        draw_profile(probe.profile, {from.x + 0.6F * em, rows.y(), plate.text_width, plate.graph - 0.4F * em}, list);
        rows.skip(plate.graph);
    }
    rows.line(probe_help(probe), plate.text_width);
    list.PopClipRect();
}

} // namespace fjell::editor
