// The glyphs that the window has: those of a text font, and of any font of the system's whatever else a name asks for.
//
// Thread: the frame's. Memory: the atlas, some hundred kB. Failure: none; what no font has is drawn as a box.
#pragma once

#include <string_view>
#include <vector>

#include <imgui.h>

namespace fjell::editor::ui {

struct Glyphs {
    std::vector<ImWchar> asked;               // beside Latin's; sorted
    bool more = false;                        // since the atlas was made
    std::vector<std::vector<ImWchar>> ranges; // that the atlas points into
};

// Of a text that is drawn and comes from elsewhere: names, paths, messages. Costs next to nothing for ASCII.
void need_glyphs(std::string_view utf8);
void need_glyph(unsigned character);
// What is asked for is drawn from the next atlas on (apply_style()).
[[nodiscard]] bool glyphs_are_missing();
// Fills the atlas, fonts found by fontconfig.
void add_fonts(ImFontAtlas& atlas, float pixels);

} // namespace fjell::editor::ui
