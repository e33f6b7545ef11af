// The materials of near ground: those that are built in, and how much of each lies at a place.
//
// Thread: the frame's. Failure: io::Failure.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "fjell/gl/layers.h"
#include "session/layers_file.h"
#include "session/session.h"

namespace fjell::editor {

// Baked from content/materials at their first use; their rules are those of content/materials/rules.
inline constexpr const char* built_in_materials = "built-in";
inline constexpr const char* built_in_rules[] = {"alpine", "nordic", "canyon"};

// Where the built-in materials are, or will be, and their recipes.
[[nodiscard]] std::string built_in_file(const std::string& cache_folder);
[[nodiscard]] std::string built_in_recipes(const std::string& cache_folder);
// Writes the recipes and rules, for a bake to read. Throws io::Failure.
void write_built_in(const std::string& cache_folder);
// The rules of that name, as a file that is written here; any other name is one of a file already.
[[nodiscard]] std::string rules_file(const std::string& cache_folder, const std::string& rules);

// Which materials lie at a place, the most first.
class GroundShares {
public:
    struct Share {
        std::string name;
        double share = 0; // 0..1
    };
    // Of the terrain that is shown; layers null: none. Reads a small mip of the pack's splat maps where the place is in
    // another tile than before.
    void follow(const session::Session& session, const session::GroundLayers* layers, const gl::LayerSettings& settings,
                double x_m, double z_m);
    [[nodiscard]] std::span<const Share> all() const { return shares_; }
    void forget() { *this = {}; }

private:
    void by_splat(const session::Session& session, double x_m, double z_m);
    void by_rules(const session::Session& session, const session::GroundLayers& layers, double x_m, double z_m);

    std::vector<Share> shares_;
    std::vector<std::string> names_; // of the pack's splat maps
    std::vector<std::byte> raw_;     // of that tile
    std::uint32_t side_ = 0;
    std::uint64_t hash_ = 0;
    std::uint32_t tile_ = ~0u;
};

} // namespace fjell::editor
