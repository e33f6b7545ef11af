// What rules of control maps would lay where, seen small before a bake: the dialog's preview.
//
// Slopes and curvatures are those of the small field, gentler than the samples' own, so shares are about. Thread: any.
// Failure: io::Failure, the baker's: file, line and rule.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fjell/gl/palette.h"

namespace fjell::baker {
class HeightSource;
} // namespace fjell::baker

namespace fjell::editor {

// A material of the rules; its colour is that of the preview and of the legend, no texture's.
struct RuleLayer {
    std::string name;
    double share = 0; // of the ground, about
    gl::Rgb8 rgb{};
};
struct RulesLook {
    std::size_t rules = 0;
    std::vector<RuleLayer> layers;     // as the pack numbers them
    double bare_share = 0;             // of the ground that no rule covers
    std::vector<float> covered;        // of each cell, 0..1
    std::vector<std::uint32_t> colour; // of each cell, RGB, 0 in the highest byte
};
// heights_m: of cells_x x cells_y cells that cover the source, NaN where there is none.
[[nodiscard]] RulesLook look_at_rules(const std::string& path, const baker::HeightSource& source, std::uint32_t cells_x,
                                      std::uint32_t cells_y, const std::vector<float>& heights_m);

} // namespace fjell::editor
