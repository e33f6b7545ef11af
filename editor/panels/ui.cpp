#include "editor/panels/ui.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>

namespace fjell::editor::ui {

namespace {

constexpr double font_px = 14;

constexpr double tip_rest_s = 0.45;
void colours(ImGuiStyle& style) {
    ImGui::StyleColorsDark(&style);
    ImVec4* const c = style.Colors;
    c[ImGuiCol_WindowBg] = {0.098F, 0.106F, 0.122F, 1};
    c[ImGuiCol_PopupBg] = {0.125F, 0.135F, 0.155F, 1};
    c[ImGuiCol_MenuBarBg] = {0.125F, 0.135F, 0.155F, 1};
    c[ImGuiCol_FrameBg] = {0.18F, 0.195F, 0.225F, 1};
    c[ImGuiCol_FrameBgHovered] = {0.235F, 0.255F, 0.3F, 1};
    c[ImGuiCol_FrameBgActive] = {0.27F, 0.3F, 0.36F, 1};
    c[ImGuiCol_Button] = {0.2F, 0.28F, 0.38F, 1};
    c[ImGuiCol_ButtonHovered] = {0.26F, 0.38F, 0.53F, 1};
    c[ImGuiCol_ButtonActive] = {0.3F, 0.46F, 0.65F, 1};
    c[ImGuiCol_SliderGrab] = {0.42F, 0.62F, 0.84F, 1};
    c[ImGuiCol_SliderGrabActive] = {0.55F, 0.74F, 0.95F, 1};
    c[ImGuiCol_CheckMark] = {0.55F, 0.74F, 0.95F, 1};
    c[ImGuiCol_Header] = {0.2F, 0.28F, 0.38F, 1};
    c[ImGuiCol_HeaderHovered] = {0.26F, 0.38F, 0.53F, 1};
    c[ImGuiCol_HeaderActive] = {0.3F, 0.46F, 0.65F, 1};
    c[ImGuiCol_TitleBgActive] = {0.16F, 0.22F, 0.3F, 1};
    c[ImGuiCol_PlotLines] = {0.55F, 0.74F, 0.95F, 1};
    c[ImGuiCol_PlotHistogram] = {0.22F, 0.4F, 0.61F, 1}; // white text is on it
    c[ImGuiCol_ModalWindowDimBg] = {0, 0, 0, 0.45F};
}

} // namespace

Context& context() {
    return *static_cast<Context*>(ImGui::GetIO().UserData);
}

void apply_style(double scale) {
    ImGuiStyle style;
    colours(style);
    style.WindowRounding = 0;
    style.FrameRounding = 3;
    style.GrabRounding = 3;
    style.PopupRounding = 4;
    style.WindowPadding = {10, 8};
    style.FramePadding = {7, 3};
    style.ItemSpacing = {7, 5};
    style.ScrollbarSize = 12;
    style.WindowBorderSize = 1;
    style.ScaleAllSizes(static_cast<float>(scale));
    ImGui::GetStyle() = style;
    ImFontAtlas* const fonts = ImGui::GetIO().Fonts;
    fonts->Clear();
    const auto pixels = static_cast<float>(font_px * scale);
    add_fonts(*fonts, pixels);
}

void mark(const char* group, const char* name) {
    const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
    mark(group, name, {low.x, low.y, high.x - low.x, high.y - low.y});
}

void mark(const char* group, const char* name, const Rect& rect) {
    mark_at(group, name, rect);
    if (context().recording && ImGui::IsItemFocused() && ImGui::GetIO().NavVisible)
        context().focus = context().marks.back().name;
}

void mark_at(const char* group, const char* name, const Rect& rect) {
    if (context().recording) context().marks.push_back({std::string(group) + "." + name, rect});
}

bool recording_marks() {
    return context().recording;
}

void leave_room() {
    const auto leave = [](auto& list) {
        if (list.Capacity < list.Size + list.Size / 2) list.reserve(2 * list.Size);
    };
    const ImDrawData& drawn = *ImGui::GetDrawData();
    for (int i = 0; i < drawn.CmdListsCount; ++i) {
        leave(drawn.CmdLists[i]->VtxBuffer);
        leave(drawn.CmdLists[i]->IdxBuffer);
        leave(drawn.CmdLists[i]->CmdBuffer);
    }
}

void record_marks(bool on) {
    context().recording = on;
    if (on) {
        context().marks.clear();
        context().focus.clear();
    }
}

const std::string& marked_focus() {
    return context().focus;
}

const std::vector<Mark>& marks() {
    return context().marks;
}

ImU32 severity_colour(Severity severity) {
    return severity == Severity::error ? bad : severity == Severity::warning ? warning_colour : good;
}

ImU32 colour(const gl::Rgb8& rgb) {
    return IM_COL32(rgb[0], rgb[1], rgb[2], 255);
}

bool begin_tip() {
    // While it is dragged, what it does beside it shall be seen.
    if (!ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return false;
    const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
    const ImGuiIO& io = ImGui::GetIO();
    const int frame = ImGui::GetFrameCount();
    Resting& resting = context().resting;
    const bool same = resting.frame >= frame - 1 && resting.at.x == low.x && resting.at.y == low.y;
    if (!same) resting = {low, ImGui::GetTime(), frame, false};
    resting.frame = frame;
    if (io.MouseDelta.x != 0 || io.MouseDelta.y != 0) resting.since_s = ImGui::GetTime();
    if (ImGui::IsAnyMouseDown() || io.MouseWheel != 0) resting.clicked = true;
    if (resting.clicked || ImGui::IsItemActive() || ImGui::GetTime() - resting.since_s < tip_rest_s) return false;
    // Above what it explains, so that what that has done, further down, is seen; at the top there is no room for it.
    const ImVec2 display = io.DisplaySize;
    const bool above = low.y > 0.35F * display.y, right = low.x > display.x / 2;
    const float gap = 0.4F * ImGui::GetFontSize();
    // Keys go on to what lies below or above: of what they are at it stands aside, where there is room.
    if (!ImGui::IsMouseHoveringRect(low, high) && display.x - high.x > 0.4F * display.x)
        ImGui::SetNextWindowPos({high.x + gap, low.y}, ImGuiCond_Always);
    else
        ImGui::SetNextWindowPos({right ? high.x : low.x, above ? low.y - gap : high.y + gap}, ImGuiCond_Always,
                                {right ? 1.0F : 0.0F, above ? 1.0F : 0.0F});
    ImGui::PushStyleVar(ImGuiStyleVar_Alpha, 1); // over a disabled item, too
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(ImGui::GetFontSize() * 30);
    return true;
}

void end_tip() {
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
    ImGui::PopStyleVar();
}

void tip(const char* text) {
    if (!begin_tip()) return;
    ImGui::TextUnformatted(text);
    end_tip();
}

double tip_due_s() {
    const Resting& resting = context().resting;
    if (resting.frame < ImGui::GetFrameCount() || resting.clicked) return -1;
    return tip_rest_s - (ImGui::GetTime() - resting.since_s);
}

void begin_column(const char* name, const Rect& rect, ImGuiWindowFlags more) {
    ImGui::SetNextWindowPos({rect.x, rect.y});
    ImGui::SetNextWindowSize({rect.width, rect.height});
    ImGui::Begin(name, nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoBringToFrontOnFocus |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing | more);
}

bool panel_button(const char* label, const char* group, const char* name, bool enabled, const char* about) {
    ImGui::BeginDisabled(!enabled);
    const bool pressed = ImGui::Button(label);
    ImGui::EndDisabled();
    control(group, name, about);
    return pressed;
}

void beside(const char* label) {
    ImGui::SameLine();
    const float width = ImGui::CalcTextSize(label).x + 2 * ImGui::GetStyle().FramePadding.x;
    if (ImGui::GetContentRegionAvail().x < width) ImGui::NewLine();
}

bool button(const char* label, bool primary) {
    int& keyboard_at = context().keyboard_at;
    const bool pressed = ImGui::Button(label);
    const bool at = ImGui::IsItemFocused() && ImGui::GetIO().NavVisible;
    if (at) keyboard_at = ImGui::GetFrameCount();
    const auto struck = [](ImGuiKey key) { return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key), false); };
    // A list that is dropped down, or a question over the dialog, has the focus instead.
    const bool enter =
        (struck(ImGuiKey_Enter) || struck(ImGuiKey_KeyPadEnter)) && !ImGui::IsWindowAppearing() &&
        ImGui::IsWindowFocused(ImGuiFocusedFlags_RootAndChildWindows | ImGuiFocusedFlags_NoPopupHierarchy) &&
        (ImGui::GetStyle().Alpha > 0.99F); // not disabled
    return pressed || (enter && (at || (primary && keyboard_at < ImGui::GetFrameCount() - 1)));
}

void focus_first() {
    if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
}

void heading(const char* text) {
    ImGui::Spacing();
    ImGui::PushStyleColor(ImGuiCol_Text, quiet);
    ImGui::TextUnformatted(text);
    ImGui::PopStyleColor();
    ImGui::Separator();
}

void right_text(const char* text, ImU32 colour) {
    const float room = ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(text).x;
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + std::max(0.0F, room));
    ImGui::PushStyleColor(ImGuiCol_Text, colour);
    ImGui::TextUnformatted(text);
    ImGui::PopStyleColor();
}

void path_text(const std::string& path) {
    need_glyphs(path);
    const float room = ImGui::GetContentRegionAvail().x;
    const char *from = path.c_str(), *const end = from + path.size();
    const bool cut = ImGui::CalcTextSize(from, end).x > room;
    const float dots = ImGui::CalcTextSize("...").x;
    // A UTF-8 character's later bytes are not shown without its first.
    while (cut && from < end && (ImGui::CalcTextSize(from, end).x + dots > room || (*from & 0xC0) == 0x80)) ++from;
    if (cut) {
        ImGui::TextUnformatted("...");
        ImGui::SameLine(0, 0);
    }
    ImGui::TextUnformatted(from, end);
    tip(path.c_str());
}

void wrapped(const char* text) {
    const float room = ImGui::GetContentRegionAvail().x, line = ImGui::GetTextLineHeight();
    const ImVec2 from = ImGui::GetCursorScreenPos();
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const ImU32 colour = ImGui::GetColorU32(ImGuiCol_Text);
    float width = 0, y = from.y;
    // A line ends at the last space before it would be too long, and nowhere else: 1,234 stays one number.
    for (const char* at = text; *at != '\0'; y += line) {
        const char *end = at, *next = at;
        for (const char* to = at;; ++to) {
            if (*to != ' ' && *to != '\n' && *to != '\0') continue;
            if (end != at && ImGui::CalcTextSize(at, to).x > room) break;
            end = to;
            next = *to == '\0' ? to : to + 1;
            if (*to != ' ') break;
        }
        list.AddText({from.x, y}, colour, at, end);
        width = std::max(width, ImGui::CalcTextSize(at, end).x);
        at = next;
    }
    ImGui::Dummy({width, std::max(y - from.y, line)});
}

void note(const char* text) {
    ImGui::PushStyleColor(ImGuiCol_Text, quiet);
    wrapped(text);
    ImGui::PopStyleColor();
}

void row(const char* label, const char* format, ...) {
    char value[96];
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(value, sizeof value, format, arguments);
    va_end(arguments);
    const float room = ImGui::GetContentRegionAvail().x;
    ImGui::TextUnformatted(label);
    // A number is never cut: where there is too little room beside the label it has a line of its own.
    if (ImGui::CalcTextSize(label).x + ImGui::CalcTextSize(value).x <= room) ImGui::SameLine(0, 0);
    right_text(value, ImGui::GetColorU32(ImGuiCol_Text));
}

} // namespace fjell::editor::ui
