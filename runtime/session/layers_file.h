// What near ground is drawn with, from files: a file of materials, and rules as JSON (content/README.md).
//
// Failure: io::Failure with exit code 1 that names the file, and of rules the line, the rule, its layer and the key.
#pragma once

#include <string>
#include <vector>

#include "fjell/gl/layers.h"
#include "fjell/io/materials.h"

namespace fjell::session {

// Rules name materials of this set.
[[nodiscard]] std::vector<gl::LayerRule> parse_layer_rules(const std::string& text, const std::string& file,
                                                           const io::Materials& materials);

struct GroundLayers {
    std::vector<std::byte> file; // that the materials point into
    io::Materials materials;
    std::vector<gl::LayerRule> rules;
};
// rules: empty: none; then only packs with splat maps have layers.
[[nodiscard]] GroundLayers read_ground_layers(const std::string& materials, const std::string& rules);

} // namespace fjell::session
