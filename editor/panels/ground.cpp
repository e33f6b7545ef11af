// The brush, the edit layers, and the brush in the picture.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <span>
#include <vector>

#include "editor/number_text.h"
#include "editor/panels/forms.h"
#include "editor/panels/panels.h"
#include "fjell/texture.h"

namespace fjell::editor {

namespace {

constexpr const char* tool_labels[] = {"Off",  "Raise", "Lower", "Level", "Smooth",  "Noise", "Crater", "Restore",
                                       "Hole", "Fill",  "Road",  "Paint", "Unpaint", "Lock",  "Unlock"};
constexpr const char* tool_abouts[] = {
    "The left button looks around.",
    "Adds metres to the ground.",
    "Takes metres away.",
    "Moves the ground to the height that it has where the stroke begins.",
    "Moves each sample to the mean of its neighbours.",
    "Adds hills as wide as the brush.",
    "A bowl with a rim.",
    "Brings back the pack's ground.",
    "Cuts the ground away: a shaft, or a tunnel's mouth.",
    "Closes holes.",
    "Levels a road along the stroke, when the button is let go. The radius is half its width.",
    "Lays a colour, or a material, over the maps.",
    "Brings back the pack's colours and materials.",
    "Keeps what any view draws within an error of the ground.",
    "Takes locks away.",
};
static_assert(std::size(tool_labels) == std::size(brush_tool_names) &&
                  std::size(tool_abouts) == std::size(brush_tool_names),
              "a brush was added: say what it does");

// A slider; true while it gives another value.
bool slider(const char* label, const char* name, double& value, double least, double most, const char* format,
            bool logarithmic, const char* about) {
    fields::label(label);
    ImGui::PushID(name);
    ImGui::SetNextItemWidth(-FLT_MIN);
    const bool given = ImGui::SliderScalar("##value", ImGuiDataType_Double, &value, &least, &most, format,
                                           logarithmic ? ImGuiSliderFlags_Logarithmic : 0);
    ui::control("brush", name, about);
    ImGui::PopID();
    value = std::clamp(value, least, most);
    return given;
}

bool has_amount(BrushTool tool) {
    return tool == BrushTool::raise || tool == BrushTool::lower || tool == BrushTool::noise ||
           tool == BrushTool::crater;
}

// Colour and material; true while they give others.
bool paint_controls(Brush& brush) {
    fields::label("Colour");
    float rgb[3];
    for (int i = 0; i < 3; ++i) rgb[i] = static_cast<float>(brush.rgb[i]) / 255;
    ImGui::SetNextItemWidth(-FLT_MIN);
    bool given = ImGui::ColorEdit3("##colour", rgb);
    ui::control("brush", "colour", "What the paint's colour is, as it is lit.");
    for (int i = 0; i < 3; ++i)
        brush.rgb[i] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(rgb[i], 0.0F, 1.0F)));
    fields::label("Material");
    int number = brush.material == no_material ? -1 : brush.material;
    ImGui::SetNextItemWidth(-FLT_MIN);
    given |=
        ImGui::SliderInt("##material", &number, -1, static_cast<int>(max_splat_names) - 1, number < 0 ? "none" : "%d");
    ui::control("brush", "material", "A number among the pack's materials, for packs that were baked with --splat.");
    brush.material = number < 0 ? no_material : static_cast<std::uint8_t>(number);
    return given;
}

// True: it may be dug.
bool say_problem(const Ground& ground) {
    if (ground.problem.empty()) return true;
    ImGui::PushStyleColor(ImGuiCol_Text, ui::warning_colour);
    ui::wrapped(ground.problem.c_str());
    ImGui::PopStyleColor();
    ui::mark("ground", "problem");
    return false;
}

} // namespace

void draw_brush(const State& state, PanelState&, Commands& commands) {
    const Ground& ground = state.ground;
    if (!say_problem(ground)) return;
    Brush brush = ground.brush;
    bool given = false;
    for (std::size_t i = 0; i < std::size(tool_labels); ++i) {
        if (i > 0) ui::beside(tool_labels[i]);
        const auto tool = static_cast<BrushTool>(i);
        const bool on = brush.tool == tool;
        if (!on) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_FrameBg));
        if (ui::panel_button(tool_labels[i], "brush", brush_tool_names[i], state.scene.open(), tool_abouts[i]))
            brush.tool = tool, given = true;
        if (!on) ImGui::PopStyleColor();
    }
    const double wide_m = std::max(state.scene.width_m(), state.scene.depth_m()),
                 least_m = std::max(0.5 * std::min(state.scene.spacing_m[0], state.scene.spacing_m[1]), least_brush_m),
                 most_m = std::clamp(wide_m / 8, 2 * least_m, most_brush_m);
    given |= slider("Radius", "radius", brush.radius_m, least_m, most_m, "%.3g m", true,
                    "Within it the brush applies wholly. The wheel over the picture changes it, too.");
    const bool locks = brush.tool == BrushTool::lock || brush.tool == BrushTool::unlock; // do not fade out
    if (!locks)
        given |= slider("Falloff", "falloff", brush.falloff_m, 0, most_m, "%.3g m", false,
                        "How far beyond the radius the brush fades out.");
    if (has_amount(brush.tool))
        given |= slider("Height", "amount", brush.amount_m, 0.01, std::max(1.0, most_m / 2), "%.3g m", true,
                        "Of a dab. A stroke has four dabs along the brush's width.");
    if (brush.tool == BrushTool::lock)
        given |= slider("Error", "error", brush.error_m, 0, 10, "%.3g m", true,
                        "No view draws the ground farther off here. 0 is exact.");
    if (!locks)
        given |= slider("Strength", "strength", brush.strength, 0, 1, "%.2f", false, "How much of all this happens.");
    if (brush.tool == BrushTool::paint) given |= paint_controls(brush);
    if (given) commands.push(SetBrush{brush});
    ui::row("Changed blocks", "%u of %u", ground.report.blocks, ground.blocks);
    ui::tip("Blocks of 32 x 32 samples that differ from the pack. A stroke that needs more is refused.");
    if (ground.report.locks != 0) {
        ui::row("Always drawn", "%u vertices", ground.always_drawn);
        ui::tip("Vertices that locks keep in every mesh. The budget of vertices should be larger.");
    }
    ui::row("Last change", "%.2f ms", ground.update_us / 1000);
    ui::tip("What applying strokes and measuring their errors took of the last frame: 4 ms at most.");
    ui::note(brush.tool == BrushTool::off ? "B takes a brush, and puts it away."
                                          : "Drag over the ground. Drag with the right button to look around.");
}

void draw_edit_layers(const State& state, PanelState& own, Commands& commands) {
    const Ground& ground = state.ground;
    if (!say_problem(ground)) return;
    for (std::size_t n = ground.layers.size(); n-- != 0;) { // the top first
        const Ground::Layer& layer = ground.layers[n];
        char name[48], text[260];
        ImGui::PushID(static_cast<int>(n));
        bool on = layer.on;
        if (ImGui::Checkbox("##on", &on)) commands.push(SetEditLayer{n, on, {}, {}});
        std::snprintf(name, sizeof name, "on.%zu", n);
        ui::control("layers", name, "Off: its strokes stay, and do nothing.");
        ImGui::SameLine();
        std::snprintf(text, sizeof text, "%s (%zu)###name", layer.name.c_str(), layer.stamps);
        if (ImGui::Selectable(text, ground.chosen == n)) commands.push(ChooseEditLayer{n});
        std::snprintf(name, sizeof name, "choose.%zu", n);
        ui::control("layers", name, "Strokes go to this layer. In brackets: its dabs.");
        if (ground.chosen == n) {
            double strength = layer.strength;
            fields::label("Strength");
            ImGui::SetNextItemWidth(-FLT_MIN);
            const double none = 0, all = 1;
            ImGui::SliderScalar("##strength", ImGuiDataType_Double, &strength, &none, &all, "%.2f");
            ui::control("layers", "strength", "How much of this layer applies, once the slider is let go.");
            if (ImGui::IsItemDeactivatedAfterEdit())
                commands.push(SetEditLayer{n, {}, std::clamp(own.layer_strength, 0.0, 1.0), {}});
            if (ImGui::IsItemActive()) own.layer_strength = strength;
        }
        ImGui::PopID();
    }
    if (ground.layers.empty()) ui::note("No strokes yet. The first makes a layer.");
    ImGui::SetNextItemWidth(-7 * ImGui::GetFontSize());
    const bool entered = ImGui::InputTextWithHint("##layer", "name", own.layer_name, sizeof own.layer_name,
                                                  ImGuiInputTextFlags_EnterReturnsTrue);
    ui::control("layers", "name", "Of a new layer, which comes on top.");
    ui::beside("New layer");
    if (ui::panel_button("New layer", "layers", "add", own.layer_name[0] != 0, "Strokes go to it.") ||
        (entered && own.layer_name[0] != 0)) {
        commands.push(AddEditLayer{own.layer_name});
        own.layer_name[0] = 0;
    }
    const std::size_t n = ground.chosen.value_or(0), count = ground.layers.size();
    if (ui::panel_button("Up", "layers", "up", ground.chosen && n + 1 < count, "Applies after the one above it."))
        commands.push(SetEditLayer{n, {}, {}, n + 1});
    ui::beside("Down");
    if (ui::panel_button("Down", "layers", "down", ground.chosen && n > 0, "Applies before the one below it."))
        commands.push(SetEditLayer{n, {}, {}, n - 1});
    ui::beside("Remove");
    if (ui::panel_button("Remove", "layers", "remove", ground.chosen.has_value(),
                         "With its strokes. Undo brings them back."))
        commands.push(RemoveEditLayer{n});
    if (count != 0) ui::path_text(ground.journal);
}

// --- In the picture.

bool draw_brush_hand(const State& state, const ui::Rect& view, BrushHand& hand, Commands& commands) {
    const ImGuiIO& io = ImGui::GetIO();
    const Ground& ground = state.ground;
    const bool on = ground.brush.tool != BrushTool::off && ground.problem.empty() && state.scene.open();
    const ImVec2 at{(io.MousePos.x - view.x) / view.width, (io.MousePos.y - view.y) / view.height};
    AimBrush aim{static_cast<double>(at.x), static_cast<double>(at.y)};
    if (hand.down && (!on || !ImGui::IsMouseDown(ImGuiMouseButton_Left))) {
        hand.down = false;
        aim.ends = true;
        commands.push(aim);
        return true;
    }
    const bool inside = at.x >= 0 && at.x <= 1 && at.y >= 0 && at.y <= 1;
    if (!on || (!hand.down && (io.WantCaptureMouse || !inside))) return false;
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) hand.down = true;
    aim.down = hand.down && inside;
    const bool moved = at.x != hand.at.x || at.y != hand.at.y;
    if (moved || aim.down) commands.push(aim);
    hand.at = at;
    if (io.MouseWheel != 0) {
        Brush brush = ground.brush;
        const double by = std::pow(1.15, static_cast<double>(io.MouseWheel));
        brush.radius_m = std::clamp(brush.radius_m * by, least_brush_m, most_brush_m);
        brush.falloff_m = std::clamp(brush.falloff_m * by, 0.0, most_brush_m);
        commands.push(SetBrush{brush});
    }
    return hand.down || io.MouseWheel != 0;
}

namespace {

// From each place to the next that is seen.
void draw_line(ImDrawList& list, const State& state, const ui::Rect& view, std::span<const Vec3> places, ImU32 colour,
               float thick) {
    std::optional<ImVec2> before;
    for (const Vec3& at : places) {
        const auto seen = place_in(state.eye.view, at);
        std::optional<ImVec2> now;
        if (seen)
            now = ImVec2{view.x + static_cast<float>((*seen)[0]) * view.width,
                         view.y + static_cast<float>((*seen)[1]) * view.height};
        if (before && now) {
            list.AddLine(*before, *now, IM_COL32(0, 0, 0, 150), thick + 2);
            list.AddLine(*before, *now, colour, thick);
        }
        before = now;
    }
}

void draw_ring(ImDrawList& list, const State& state, const ui::Rect& view,
               const std::array<Vec3, Ground::ring_points>& ring, ImU32 colour, float thick) {
    draw_line(list, state, view, ring, colour, thick);
    draw_line(list, state, view, std::array{ring.back(), ring.front()}, colour, thick);
}

} // namespace

void draw_brush_ring(const State& state, const ui::Rect& view) {
    const Ground& ground = state.ground;
    if (ground.brush.tool == BrushTool::off || !ground.at) return;
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    list.PushClipRect({view.x, view.y}, {view.x + view.width, view.y + view.height});
    const auto thick = static_cast<float>(1.5 * state.interface.scale);
    draw_ring(list, state, view, ground.outer, IM_COL32(255, 214, 102, 140), 0.7F * thick);
    draw_ring(list, state, view, ground.inner, IM_COL32(255, 214, 102, 255), thick);
    std::vector<Vec3> road;
    for (const StampPoint& p : ground.road) road.push_back({p.x_m, static_cast<double>(p.height_m), p.z_m});
    draw_line(list, state, view, road, IM_COL32(255, 214, 102, 255), thick);
    list.PopClipRect();
}

} // namespace fjell::editor
