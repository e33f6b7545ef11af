// From heights to a pack: read, fill, measure, maps, vertices step by step, assemble (thesis 5.3).
// Out of core: what does not fit the memory lies in a folder beside the pack, PACK.work, and a bake that was
// interrupted or killed goes on from the last stage that was complete.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "baker/heights/statistics.h"
#include "baker/maps/smooth.h"
#include "baker/read/source.h"
#include "fjell/pack.h"
#include "shared/tree.h"

namespace fjell::baker {

// stage: what is being done; done, total: in units of the stage (samples, tiles or chunks). May throw Failure to stop.
using Progress = std::function<void(const char* stage, std::uint64_t done, std::uint64_t total)>;

// The pack depends on the source and on these, but not on those under "how".
struct BakeOptions {
    int tile_log2 = 0; // 0: auto
    ErrorEstimate estimate = ErrorEstimate::max;
    double nesting = 0.05;              // mu, 0.001..1
    std::string locks_path;             // where errors are smaller (locks/locks.h); empty: nowhere
    std::optional<double> lock_error_m; // of locks that say none
    bool room_for_holes = false;        // errors have codes for a hole's rim, whether there are holes or not
    bool room_for_locks = false;        // and for what locks keep in every mesh, whether there are some or not
    PageOrder order = PageOrder::planar;
    double quantum_m = 0; // the vertical height scale's step; 0: the source's own, or the smallest that is of use
    std::vector<std::string> texture_paths; // ortho-images (image.h), the last one uppermost
    std::string texture_bands;              // open_images()
    std::string ramp_path; // colours by height and slope, also where no image is; empty: meadows to snow
    std::string reading;   // how the source was read, for the pack's notes (pack/notes.h); empty: they do not say
    std::uint32_t max_texture_log2 = 10;
    int horizon_spacing = 0; // samples from texel to texel of horizon maps, nearly: 2 or 4; 0: none
    std::string layers_path; // rules of splat maps (maps/splat.h); empty: none
    int splat_spacing = 2;   // samples from texel to texel of splat maps, nearly: 1, 2 or 4
    // Of a pack with stamps, what these do not reach is taken out of the pack, where that gives the same bytes.
    bool keep_unchanged = true;
    int compression = -3; // zstd level of maps, whose blocks hardly shrink: -3 is 3% larger than 1 and costs half

    // How.
    int threads = 0;                                       // 0: all cores
    std::uint64_t memory_bytes = std::uint64_t{512} << 20; // resident at most, with the program itself
    std::int32_t region_cells = 256;                       // a side of what is worked on at once, at least; or one tile
    std::size_t whole_level_vertices = std::size_t{1} << 22; // of a level for horizons that each shard reads whole
    // Given: complete stages are kept in the work folder even of a bake that fits the memory and would be over before
    // it matters. When the input fails after less than this many seconds (not given: 5), nothing is kept.
    std::optional<double> checkpoint_s;
    Progress progress;
};

struct BakeSummary {
    std::int32_t columns = 0, rows = 0;
    Tree tree;
    double spacing_m[2] = {0, 0};
    float quantum_m = 0, min_m = 0, max_m = 0;
    // The range of heights within one tile that made quantum_m as large as it is; 0: it was asked for, or is the
    // source's own or fine enough for anything.
    float quantum_range_m = 0;
    float max_error_m = 0;    // of any vertex: beside a hole an error is at least the size of its triangles
    float ground_error_m = 0; // how far ground lies from a triangle that could be drawn over it, at most
    std::string crs_wkt;      // empty: none
    SourceFacts source;
    std::string locks;               // what they are, and cost; empty: none
    std::uint64_t always_drawn = 0;  // vertices that locks keep in every mesh, and what these ask for
    std::vector<std::string> images; // an account of each texture (ImageSource::accounts)
    std::uint64_t voids = 0;         // samples that are holes
    RepeatedHeight lowest, highest;  // that many samples share; share 0: no such height
    std::uint64_t file_bytes = 0, geometry_bytes = 0, directory_bytes = 0, texture_bytes = 0,
                  horizon_bytes = 0, // those of the textures that are horizon maps
        splat_bytes = 0;             // and splat maps
    bool resumed = false;            // some stages were complete from an earlier run
    std::uint64_t enough_bytes = 0;  // of memory, for a bake that worked in files; 0: it did not, or had to, or they
                                     // are more than half of this machine's
    // Of a pack with stamps: how many of the bytes are the pack's own, because no stamp reaches them; 0 and a line that
    // says why: all of it was baked.
    std::uint64_t kept_bytes = 0;
    std::string kept_nothing;
    HeightStatistics heights; // of all samples, and whether each lies on the pack's height scale bit for bit
    bool on_scale = false;
    SmoothGround smooth;       // what its maps were made from
    bool work_damaged = false; // an earlier run's work was not as it had left it, and all was done anew
    // Read, filled and measured; colour and normal maps; horizon maps; splat maps; vertices; assembled and on the
    // disk; everything.
    double seconds_read = 0, seconds_textures = 0, seconds_horizons = 0, seconds_splat = 0, seconds_errors = 0,
           seconds_write = 0, seconds_total = 0;
};

// What a user may not expect of a bake, a line each: heights that may be no ground, a quantum that is coarse, and
// memory that was not used.
[[nodiscard]] std::vector<std::string> remarks(const BakeSummary& summary);

// Bakes to OUT beside its place and renames; an old pack stays until then. Throws Failure. When that is an interruption
// (130) or a failure of the input, and a stage is complete, PACK.work stays and the same call goes on; otherwise
// nothing is left behind. What an earlier run has left is compared with checksums before it is used. O(samples) of disk
// beside the pack (work_bytes()). One at a time for each OUT.
BakeSummary bake(const HeightSource& source, const BakeOptions& options, const std::string& out_path);

} // namespace fjell::baker
