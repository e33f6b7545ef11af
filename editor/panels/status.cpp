// The line at the bottom: the newest message, and the figures that matter most; what has no room is left out, the least
// important first.
#include <algorithm>
#include <array>
#include <cstdio>

#include "editor/number_text.h"
#include "editor/panels/panels.h"

namespace fjell::editor {

namespace {

struct Part {
    char text[64] = "";
    ImU32 colour = 0;
    int importance = 0; // 1 goes last
    const char* name = "";
    const char* about = "";
};

// Green: as asked for. Amber: it lags, or pages are missing. Red: a budget does not suffice.
Part threshold_part(const State& state) {
    const flight::FrameEntry& e = state.measures.last();
    Part part{"", ui::good, 1, "threshold",
              "The threshold that the mesh keeps now, and why it is not the requested one."};
    constexpr std::uint32_t lasting = flight::exhausted_vertices | flight::exhausted_indices |
                                      flight::exhausted_triangles | flight::exhausted_page_slots;
    const char* why = "";
    if ((e.exhausted & lasting) != 0) {
        part.colour = ui::bad;
        why = (e.exhausted & flight::exhausted_vertices) != 0    ? "vertices exhausted"
              : (e.exhausted & flight::exhausted_triangles) != 0 ? "triangles exhausted"
              : (e.exhausted & flight::exhausted_indices) != 0   ? "indices exhausted"
                                                                 : "page slots exhausted";
    } else if (e.streamed && !e.stream.converged) {
        part.colour = ui::warning_colour;
        why = "pages missing";
    } else if (!e.converged) {
        part.colour = ui::warning_colour;
        why = (e.exhausted & flight::exhausted_items) != 0  ? "lags: work items exhausted"
              : (e.exhausted & flight::exhausted_time) != 0 ? "lags: time exhausted"
              : e.morphing > 0                              ? "morphing"
                                                            : "lags";
    }
    if (e.error_px_effective >= 1e6)
        std::snprintf(part.text, sizeof part.text, "error unbounded, %s", why);
    else
        std::snprintf(part.text, sizeof part.text, "within %.4g px%s%s", e.error_px_effective, *why ? ", " : "", why);
    return part;
}

Part stream_part(const State& state) {
    const StreamReport& r = state.measures.last().stream;
    const bool there = r.converged && r.maps_converged;
    Part part{"", there ? ui::good : ui::warning_colour, 4, "streaming",
              "Whether everything that the view needs is loaded."};
    if (there)
        std::snprintf(part.text, sizeof part.text, "streaming: complete");
    else
        std::snprintf(part.text, sizeof part.text, "streaming: %.12s wanted, %.12s in flight",
                      count_text(r.pages_wanted).text, count_text(r.in_flight).text);
    return part;
}

using Parts = std::array<Part, 6>;

std::size_t make_parts(const State& state, Parts& parts) {
    const Measures& m = state.measures;
    const ImU32 plain = ImGui::GetColorU32(ImGuiCol_Text);
    std::size_t n = 0;
    if (!state.scene.open()) {
        parts[n] = {"", ui::quiet, 1, "nothing", "Use File > Open, or drop a file here."};
        std::snprintf(parts[n].text, sizeof parts[n].text, "no terrain is open");
        return 1;
    }
    parts[n++] = threshold_part(state);
    if (m.ring(Series::update_us).size() != 0) {
        Part& update = parts[n++] = {"", plain, 2, "update",
                                     "The longest of the last 512 updates, without the slowest hundredth."};
        std::snprintf(update.text, sizeof update.text, "update p99 %s ms",
                      ms_text(static_cast<double>(m.ring(Series::update_us).quantiles().p99)).text);
        Part& fps = parts[n++] = {"", plain, 3, "fps", "Frames per second, from the median frame time."};
        const float frame_us = m.ring(Series::frame_us).quantiles().p50;
        std::snprintf(fps.text, sizeof fps.text, "%.0f fps", frame_us > 0 ? 1e6 / static_cast<double>(frame_us) : 0.0);
    }
    if (m.last().streamed) parts[n++] = stream_part(state);
    Part& drawn = parts[n++] = {"", plain, 5, "triangles", "Triangles drawn in this frame."};
    std::snprintf(drawn.text, sizeof drawn.text, "%s triangles", count_text(m.last().triangles_drawn).text);
    return n;
}

float width_of(const Parts& parts, std::size_t n, float gap) {
    float width = 0;
    for (std::size_t i = 0; i < n; ++i) width += ImGui::CalcTextSize(parts[i].text).x + gap;
    return width;
}

void drop_least(Parts& parts, std::size_t& n) {
    const auto end = parts.begin() + static_cast<std::ptrdiff_t>(n);
    const auto least =
        std::max_element(parts.begin(), end, [](const Part& a, const Part& b) { return a.importance < b.importance; });
    std::move(least + 1, end, least);
    --n;
}

// One line of it, cut with dots where it is too long; a click shows all messages.
void draw_message(const State& state, float room, Commands& commands) {
    const Message& newest = state.messages.all.back();
    const ImVec2 from = ImGui::GetCursorScreenPos();
    const float em = ImGui::GetFontSize();
    if (ImGui::InvisibleButton("message", {std::max(room, em), em})) commands.push(ShowDialog{Dialog::messages});
    ui::mark("status", "message");
    ui::tip(newest.text.c_str());
    const char* const text = newest.text.c_str();
    const char* end = text + newest.text.size();
    const float dots = ImGui::CalcTextSize(" ...").x;
    const bool long_one = ImGui::CalcTextSize(text, end).x > room;
    // A UTF-8 character's later bytes are not cut from its first.
    while (long_one && end > text && (ImGui::CalcTextSize(text, end).x + dots > room || (*end & 0xC0) == 0x80)) --end;
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const ImU32 colour = ui::severity_colour(newest.severity);
    list.AddText(from, colour, text, end);
    if (long_one) list.AddText({from.x + ImGui::CalcTextSize(text, end).x, from.y}, colour, " ...");
}

} // namespace

void draw_status(const State& state, const ui::Layout& layout, Commands& commands) {
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const float em = ImGui::GetFontSize(), gap = 1.4F * em;
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0.7F * em, 0.5F * (layout.status_height - em) - 1});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1, 1});
    ui::begin_column("status", {0, display.y - layout.status_height, display.x, layout.status_height});
    ImGui::PopStyleVar(2);
    draw_job_status(state, commands);
    Parts parts;
    std::size_t n = make_parts(state, parts);
    const bool message = !state.messages.all.empty() && state.now_s < state.messages.shown_until_s;
    const float all = ImGui::GetContentRegionAvail().x, least_message = message ? 16 * em : 0;
    while (n > 1 && width_of(parts, n, gap) + least_message > all) drop_least(parts, n);
    for (std::size_t i = 0; i < n; ++i) {
        if (i > 0) ImGui::SameLine(0, gap);
        ImGui::PushStyleColor(ImGuiCol_Text, parts[i].colour);
        ImGui::TextUnformatted(parts[i].text);
        ImGui::PopStyleColor();
        ui::mark("status", parts[i].name);
        ui::tip(parts[i].about);
    }
    if (message) {
        ImGui::SameLine(0, gap);
        draw_message(state, ImGui::GetContentRegionAvail().x, commands);
    }
    ImGui::End();
}

} // namespace fjell::editor
