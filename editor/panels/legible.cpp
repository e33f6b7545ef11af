#include "editor/panels/legible.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <imgui.h>
#include <imgui_internal.h> // which window a list of draw commands belongs to

namespace fjell::editor::ui {

namespace {

constexpr float slack_px = 1.5F; // letters are rounded to pixels

// As much may letters lie over their neighbours: an f leans over a j.
float lean_px() {
    return slack_px + 0.12F * ImGui::GetFontSize();
}

// Letters in a row, as one call has drawn them or several one behind the other.
struct Text {
    std::string letters;
    ImVec2 low, high, last_low, last_high;
    ImVec4 clip;
    bool cut_x = false, cut_y = false; // letters of it were cut as they were written, to fit a control or the window
    bool in_field = false;
};

// Four vertices and six indices, as ImGui writes a rectangle.
bool is_rectangle(const ImDrawIdx* i, const ImDrawVert* v) {
    const ImDrawIdx a = i[0];
    if (i[1] != a + 1 || i[2] != a + 2 || i[3] != a || i[4] != a + 2 || i[5] != a + 3) return false;
    return v[a].pos.y == v[a + 1].pos.y && v[a + 1].pos.x == v[a + 2].pos.x && v[a + 2].pos.y == v[a + 3].pos.y;
}

// The letter in whose picture this part lies; null: it is none.
const ImFontGlyph* letter_of(const ImFont& font, const ImVec2& from, const ImVec2& to) {
    constexpr float e = 1e-6F;
    const auto* const found = std::find_if(font.Glyphs.begin(), font.Glyphs.end(), [&](const ImFontGlyph& g) {
        return g.U0 <= from.x + e && g.V0 <= from.y + e && g.U1 >= to.x - e && g.V1 >= to.y - e && g.U1 > g.U0;
    });
    return found == font.Glyphs.end() ? nullptr : found;
}

bool is_field(ImU32 colour) {
    const ImU32 rgb = ~static_cast<ImU32>(IM_COL32_A_MASK);
    return std::ranges::any_of(std::initializer_list<ImGuiCol>{ImGuiCol_FrameBg, ImGuiCol_FrameBgHovered,
                                                               ImGuiCol_FrameBgActive, ImGuiCol_TextSelectedBg},
                               [&](ImGuiCol of) {
                                   return (ImGui::ColorConvertFloat4ToU32(ImGui::GetStyle().Colors[of]) & rgb) ==
                                          (colour & rgb);
                               });
}

class Reader {
public:
    Reader(const ImFont& font, const ImTextureID& letters) : font_(font), atlas_(letters) {}

    std::vector<Text> read(const ImDrawList& list) {
        texts_.clear();
        for (const ImDrawCmd& command : list.CmdBuffer) {
            going_on_ = false;
            if (command.UserCallback == nullptr) read(list, command);
        }
        return std::move(texts_);
    }

private:
    void read(const ImDrawList& list, const ImDrawCmd& command) {
        const ImDrawIdx* const indices = list.IdxBuffer.Data + command.IdxOffset;
        const ImDrawVert* const vertices = list.VtxBuffer.Data + command.VtxOffset;
        for (unsigned i = 0; i + 3 <= command.ElemCount;) {
            const bool rectangle = i + 6 <= command.ElemCount && is_rectangle(indices + i, vertices);
            const ImDrawVert* const v = vertices + indices[i];
            const bool letter = rectangle && command.TextureId == atlas_ && v[0].uv.x != v[2].uv.x;
            const ImFontGlyph* const glyph = letter ? letter_of(font_, v[0].uv, v[2].uv) : nullptr;
            if (glyph != nullptr)
                add(*glyph, v, command.ClipRect);
            else
                under_ = v->col, going_on_ = false;
            i += rectangle ? 6 : 3;
        }
    }

    void add(const ImFontGlyph& glyph, const ImDrawVert* v, const ImVec4& clip) {
        const ImVec2 low = v[0].pos, high = v[2].pos;
        const float em = font_.FontSize;
        Text* t = texts_.empty() ? nullptr : &texts_.back();
        if (!going_on_ || t == nullptr || low.x < t->last_high.x - lean_px() || low.x > t->last_high.x + 2 * em ||
            std::abs(low.y + high.y - t->last_low.y - t->last_high.y) > 1.4F * em) {
            texts_.push_back({{}, low, high, low, high, clip, false, false, is_field(under_)});
            t = &texts_.back();
        }
        going_on_ = true;
        t->letters += glyph.Codepoint < 128 ? static_cast<char>(glyph.Codepoint) : '?';
        const float hidden_wide = (glyph.X1 - glyph.X0) - (high.x - low.x),
                    hidden_high = (glyph.Y1 - glyph.Y0) - (high.y - low.y);
        t->cut_x = t->cut_x || hidden_wide > slack_px;
        t->cut_y = t->cut_y || hidden_high > slack_px;
        t->low = {std::min(t->low.x, low.x), std::min(t->low.y, low.y)};
        t->high = {std::max(t->high.x, high.x), std::max(t->high.y, high.y)};
        t->last_low = low;
        t->last_high = high;
    }

    const ImFont& font_;
    const ImTextureID atlas_;
    std::vector<Text> texts_;
    ImU32 under_ = 0; // the colour of what was drawn last that is no letter
    bool going_on_ = false;
};

bool is_seen(const Text& t) {
    return t.high.x > t.clip.x && t.low.x < t.clip.z && t.high.y > t.clip.y && t.low.y < t.clip.w;
}

bool scrolls(const ImGuiWindow* window, ImGuiAxis axis) {
    for (; window != nullptr; window = window->ParentWindow)
        if (window->ScrollMax[static_cast<std::size_t>(axis)] > 0) return true;
    return false;
}

bool is_cut(const Text& t, const ImGuiWindow* window) {
    const bool across = t.low.x < t.clip.x - slack_px || t.high.x > t.clip.z + slack_px,
               along = t.low.y < t.clip.y - slack_px || t.high.y > t.clip.w + slack_px;
    return ((across || (t.cut_x && !t.in_field)) && !scrolls(window, ImGuiAxis_X)) ||
           ((along || t.cut_y) && !scrolls(window, ImGuiAxis_Y));
}

bool lie_over_each_other(const Text& a, const Text& b) {
    const float x = std::min(std::min(a.high.x, a.clip.z), std::min(b.high.x, b.clip.z)) -
                    std::max(std::max(a.low.x, a.clip.x), std::max(b.low.x, b.clip.x));
    const float y = std::min(std::min(a.high.y, a.clip.w), std::min(b.high.y, b.clip.w)) -
                    std::max(std::max(a.low.y, a.clip.y), std::max(b.low.y, b.clip.y));
    return x > lean_px() && y > lean_px();
}

} // namespace

std::vector<std::string> illegible_texts() {
    std::vector<std::string> found;
    if (ImGui::GetCurrentContext() == nullptr) return found;
    const ImDrawData* const data = ImGui::GetDrawData();
    if (data == nullptr) return found;
    const ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
    Reader reader(*fonts.Fonts.front(), fonts.TexID);
    for (int i = 0; i < data->CmdListsCount; ++i) {
        const ImDrawList& list = *data->CmdLists[i];
        const char* const name = list._OwnerName != nullptr ? list._OwnerName : "";
        const ImGuiWindow* const window = ImGui::FindWindowByName(name);
        const std::vector<Text> texts = reader.read(list);
        for (auto t = texts.begin(); t != texts.end(); ++t) {
            if (!is_seen(*t)) continue;
            if (is_cut(*t, window)) found.push_back(std::string(name) + ": " + t->letters);
            for (auto other = texts.begin(); other != t; ++other)
                if (is_seen(*other) && lie_over_each_other(*t, *other))
                    found.push_back(std::string(name) + ": " + t->letters + " | " + other->letters);
        }
    }
    return found;
}

} // namespace fjell::editor::ui
