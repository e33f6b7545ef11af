#include "editor/panels/ui.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <filesystem>

namespace fjell::editor::ui {

namespace {

// Debian's fonts-dejavu-core; without it ImGui's own bitmap font, which is legible at any scale too.
constexpr const char* font_file = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
constexpr double font_px = 14;

std::vector<Mark> standard_folders;
bool recording = false;

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
    std::error_code ignored;
    if (std::filesystem::exists(font_file, ignored) && fonts->AddFontFromFileTTF(font_file, pixels) != nullptr) return;
    ImFontConfig own;
    own.SizePixels = static_cast<float>(13 * scale);
    fonts->AddFontDefault(&own);
}

Layout layout(float width, float height, double scale) {
    const auto s = static_cast<float>(scale);
    Layout l;
    l.menu_height = ImGui::GetFrameHeight();
    l.status_height = ImGui::GetFrameHeight() + 2 * s;
    const float top = l.menu_height, rest = std::max(height - top - l.status_height, 1.0F);
    const float left = std::min(340 * s, width * 0.55F), right = 350 * s;
    const bool two = width >= left + right + 480 * s;
    l.left = {0, top, left, rest};
    if (two) l.right = {width - right, top, right, rest};
    l.view = {left, top, std::max(width - left - (two ? right : 0), 1.0F), rest};
    return l;
}

void mark(const char* group, const char* name) {
    if (!recording) return;
    const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
    standard_folders.push_back({std::string(group) + "." + name, {low.x, low.y, high.x - low.x, high.y - low.y}});
}

void record_marks(bool on) {
    recording = on;
    if (on) standard_folders.clear();
}

const std::vector<Mark>& marks() {
    return standard_folders;
}

ImU32 severity_colour(Severity severity) {
    return severity == Severity::error ? bad : severity == Severity::warning ? warning_colour : good;
}

ImU32 colour(const gl::Rgb8& rgb) {
    return IM_COL32(rgb[0], rgb[1], rgb[2], 255);
}

void tip(const char* text) {
    // While it is dragged, what it does beside it shall be seen.
    if (!ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled) || ImGui::IsItemActive()) return;
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(ImGui::GetFontSize() * 30);
    ImGui::TextUnformatted(text);
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
}

void begin_column(const char* name, const Rect& rect) {
    ImGui::SetNextWindowPos({rect.x, rect.y});
    ImGui::SetNextWindowSize({rect.width, rect.height});
    ImGui::Begin(name, nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoBringToFrontOnFocus |
                     ImGuiWindowFlags_NoSavedSettings);
}

void begin_dialog(const char* title, double width, double height, const State& state, bool& open) {
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const auto fit = [&](double unscaled, float most) {
        return std::min(static_cast<float>(unscaled * state.interface.scale), 0.96F * most);
    };
    ImGui::SetNextWindowPos({display.x / 2, display.y / 2}, ImGuiCond_Always, {0.5F, 0.5F});
    ImGui::SetNextWindowSize({fit(width, display.x), fit(height, display.y)}, ImGuiCond_Always);
    ImGui::SetNextWindowSizeConstraints({0, 0}, {display.x, 0.96F * display.y});
    ImGui::Begin(title, &open,
                 ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                     ImGuiWindowFlags_NoSavedSettings);
}

void heading(const char* text) {
    ImGui::Spacing();
    ImGui::PushStyleColor(ImGuiCol_Text, quiet);
    ImGui::TextUnformatted(text);
    ImGui::PopStyleColor();
    ImGui::Separator();
}

void row(const char* label, const char* format, ...) {
    char value[96];
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(value, sizeof value, format, arguments);
    va_end(arguments);
    ImGui::TextUnformatted(label);
    const float width = ImGui::CalcTextSize(value).x;
    ImGui::SameLine(std::max(ImGui::GetContentRegionMax().x - width, ImGui::CalcTextSize(label).x));
    ImGui::TextUnformatted(value);
}

} // namespace fjell::editor::ui
