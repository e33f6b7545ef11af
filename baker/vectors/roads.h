// Roads and rivers of a map, as stamps (fjell/edit.h) of ground that they have changed.
//
// Roads keep their largest grade, and leave the ground as little as that allows (profile.h): the whole network at once,
// so roads that meet have one height there. Beside bends, crossings and other roads the grade also holds between places
// that are near each other as the crow flies, because the ground there is shared by both. Rivers have the lowest ground
// of all that lies upstream, less their depth: water runs on. They only take ground away.
//
// Units: metres; slopes and grades are metres up a metre. Complexity and memory: those of network.h, profile.h and
// earthworks.h. Failure: Failure 1 for a file that cannot be read, attributes out of range, nothing on the terrain.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "baker/read/source.h"
#include "baker/vectors/earthworks.h"
#include "baker/vectors/network.h"
#include "fjell/io/journal.h"

namespace fjell::baker {

enum class LineKind : std::uint8_t { road, river };

struct LineOptions {
    double width_m = 6;
    double shoulder_m = 1;   // on either side, as level as the road
    double max_grade = 0.12; // of roads
    double smooth_m = 30;    // bumps of the ground that are shorter do not become the road's; 0: all of them may
    double depth_m = 1;      // of rivers, below the lowest ground
    EarthworkSlopes slopes;  // a river has a cut slope alone: its banks'
    std::optional<std::array<std::uint8_t, 3>> paint;
    std::uint8_t material = no_material;
};
inline constexpr double least_width_m = 0.1, most_width_m = 1000, least_grade = 1e-3, most_grade = 10,
                        most_depth_m = 1000;

struct MapLine {
    std::vector<Place> places;
    double width_m = 0, max_grade = 0, depth_m = 0;
};
// The lines of a file in the metres of a terrain. Attributes take the place of the options: `width_m`, or else
// OpenStreetMap's `width`; `max_grade` of roads; `depth_m` of rivers. layer: of the file; empty: all of them.
[[nodiscard]] std::vector<MapLine> read_map_lines(const std::string& path, const std::string& layer,
                                                  const HeightSource& terrain, LineKind kind,
                                                  const LineOptions& options);

struct LineSummary {
    std::size_t lines = 0; // with something on the terrain
    double length_m = 0;
    double ground_grade = 0, grade = 0;  // the steepest along lines, before and after
    double bed_width_m = 0, asked_m = 0; // of the narrowest: what samples make of it, where they lie too wide apart
    double most_off_m = 0;               // the farthest that a centre line lies from the ground
    EarthworkSummary ground;
};
struct MadeLines {
    std::vector<io::KeptStamp> stamps; // heights first, then paint
    LineSummary summary;
};
// terrain: heights that roads are laid on. name: of the file, for messages.
[[nodiscard]] MadeLines make_lines(const HeightSource& terrain, const std::vector<MapLine>& lines, LineKind kind,
                                   const LineOptions& options, const std::string& name);

} // namespace fjell::baker
