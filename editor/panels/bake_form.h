// The dialog that bakes, in its parts: the form (bake_form.cpp), what was found in the files and what will happen
// (bake_facts.cpp), and the dialog around them (bake.cpp).
//
// Thread: the frame's, inside the dialog's window. What is typed lives in the form, and goes to the state as a draft,
// which is looked at (jobs/height_look.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "editor/panels/fields.h"
#include "editor/panels/file_browser.h"

namespace fjell::editor::bake_dialog {

// Words of fjell-bake, in the order in which the form lists them.
inline constexpr const char* control_names[] = {"full", "half", "quarter"};
inline constexpr const char* horizon_names[] = {"none", "half", "quarter"};
inline constexpr int usual_control = 1; // fjell-bake's default
// 0 where the name is none of them.
[[nodiscard]] std::size_t index_of(const std::string& name, std::span<const char* const> names);

struct Form {
    std::uint64_t given = ~std::uint64_t{0}; // BakeDraft::given that it holds
    fields::PathText input = "", output = "", texture = "", ramp = "", rules = "", voids = "", crs = "", bbox = "";
    std::vector<std::string> more; // heights, beside the first
    bool output_is_chosen = false;
    int tile = 0, order = 0, nodata = 0, control = usual_control, horizons = 0, encoding = 0;
    double spacing_m = 0, height_scale = 1, height_offset_m = 0;
    BakePack sent;
    BakeField browsing = BakeField::none; // for this one's file
    bool browsing_another = false;
    FileBrowserForm browser, overwrite;
};

// What the draft holds, as the form has it; and back.
void load(Form& form, const BakeDraft& draft);
[[nodiscard]] BakePack pack_of(const Form& form);
void draw_form(Form& form, const State& state, Commands& commands);

void draw_facts(const BakeDraft& draft);
// In words: what is in the way or, where nothing is, what the button does.
void draw_plan(const State& state);
// A path's last part.
[[nodiscard]] const char* name_in(const std::string& path);

} // namespace fjell::editor::bake_dialog
