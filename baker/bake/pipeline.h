// A bake from stage to stage (docs/notes/baking.md). What a stage leaves behind lies in stores; what it does is cut
// into units that depend on nothing but the stores of the stages before, so that threads, memory and interruptions
// change nothing in the result.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "baker/bake/bake.h"
#include "baker/bake/ledger.h"
#include "baker/bake/store.h"
#include "baker/errors/level.h"
#include "baker/errors/own.h"
#include "baker/heights/ground.h"
#include "baker/maps/image.h"
#include "baker/maps/maps.h"
#include "baker/pack/write.h"

namespace fjell::baker {

// In this order; `maps` is a stage for near mips and one for each further mip, `levels` one for each step.
enum class Stage : std::uint32_t { read, fill, survey, maps, vertices, levels, plain_pages, assemble };

// What a centre hands on to the coarser step.
struct CentreRecord {
    std::int32_t steps = 0;
    std::uint8_t error = 0, radius = 0;
    std::uint16_t unused = 0;
};
static_assert(sizeof(CentreRecord) == 8, "CentreRecord lies in a work file");

// The highest bit of steps in stores: a hole.
inline constexpr std::uint32_t void_flag = 0x80000000u;

class Pipeline {
public:
    Pipeline(const HeightSource& source, const BakeOptions& options, const std::string& out_path);
    BakeSummary run();

private:
    // ---- stages, in order; each one may be entered again after an interruption
    void read();
    void fill();
    void survey();
    void plan();      // height scale, scales, header, spool: from what is known by now
    void make_maps(); // near mips tile by tile, then far mips
    void make_near_maps();
    void make_far_mip(MapKind kind, std::uint32_t mip);
    void vertices();    // the finest step, and own errors of all others
    void level(int z);  // each further step
    void plain_pages(); // pages of several steps, corners, CRS
    std::uint64_t assemble(BakeSummary& summary);

    // Runs unit(i) for the units of a stage that are not done yet. in_order: called for each as soon as it and all
    // before it are done, one at a time.
    struct StageRun {
        std::uint32_t index;
        const char* name;
        std::uint64_t count;
        int workers;
        double each; // what a unit counts in the progress
        std::function<void(std::uint64_t)> in_order = {};
    };
    void run_units(const StageRun& stage, const std::function<void(std::uint64_t)>& unit);
    // As many threads as the memory allows, of which a unit takes so much at its largest.
    [[nodiscard]] int workers_for(std::uint64_t bytes) const;
    [[nodiscard]] bool done(std::uint32_t stage) const { return ledger_.state.stage > stage; }
    void finish(std::uint32_t stage); // its stores are complete
    void checkpoint();
    [[nodiscard]] static constexpr std::uint32_t index(Stage stage, int z = 0) {
        // Numbers with room for as many levels and mips as there can be.
        return static_cast<std::uint32_t>(stage) * 100 + static_cast<std::uint32_t>(z);
    }

    // ---- pieces of the terrain
    // Of a store; empty: in memory.
    [[nodiscard]] std::string file(const std::string& name) const { return in_memory_ ? "" : folder_.file(name); }
    [[nodiscard]] bool fits_memory() const;
    [[nodiscard]] double checkpoint_s() const { return options_.checkpoint_s.value_or(5); }
    [[nodiscard]] std::string temporary() const; // where the pack grows; empty: at its own place
    [[nodiscard]] const Store<float>& heights() const { return filled_.exists() ? filled_ : raw_; }
    // The places of step 2^z from twice square (-1, -1) of the region on, as level.h wants them.
    [[nodiscard]] Ground ground_of(const Region& region) const;
    void load_level(const Region& region, int z, Planes<std::int32_t>& steps, Planes<std::uint8_t>& voids) const;
    void load_finer(const Region& region, int z, FinerCentres& finer) const;
    void load_own(const Region& region, std::int64_t region_index, int z, Planes<std::uint8_t>& error) const;
    void fix_leaves(const Ground& ground, const LevelInput& level) const;
    // What a step leaves behind: the next one's places and centres, records of plain pages, its own pages.
    struct LevelResult {
        const Region& region;
        const LevelInput& level;
        const Radii& radii;
        const Planes<std::uint8_t>* voids;
    };
    void keep_level(const LevelResult& result);
    void keep_records(const LevelResult& result);
    void pack_pages(const LevelResult& result);
    void store_own(std::int64_t region_index, const Region& region, const Patch<std::uint8_t>& own);
    void open_level_stores(int z);
    [[nodiscard]] std::int32_t squares(std::int32_t cells, int z) const { return cells >> (z + 1); }
    [[nodiscard]] Survey survey_region(const Region& region, Buffer<float>& buffer) const;
    void write_corners();
    [[nodiscard]] std::vector<ChunkId> chunk_sequence() const;
    void plan_maps();
    void open_texels(MapKind kind, std::uint32_t mip);
    [[nodiscard]] std::unique_ptr<ImageReader> take_reader();
    void give_reader(std::unique_ptr<ImageReader> reader);
    [[nodiscard]] PackHeader make_header() const;
    void check_header() const;
    [[nodiscard]] std::string identity() const;
    void store_texels(MapKind kind, std::uint32_t mip, std::uint32_t tile, const Texels& texels);

    const HeightSource& source_;
    const BakeOptions& options_;
    const std::string out_path_;
    const Tree tree_;
    const Regions regions_;
    const PageLayout pages_;
    const int threads_;
    // The finest step whose vertices lie in pages of several steps; linear order: all of them.
    const int plain_z_;

    WorkFolder folder_;
    const bool in_memory_;               // nothing but the pack itself goes to the folder, and nothing can be resumed
    std::unique_ptr<ImageSource> image_; // or none
    Ledger ledger_;
    bool input_at_work_ = false; // what fails now is the input, which may come back
    std::optional<ChunkSpool> spool_;
    std::mutex lock_;
    std::chrono::steady_clock::time_point last_checkpoint_;

    Store<float> raw_, filled_;                // samples; raw: NaN where there is none
    Store<std::uint8_t> voids_;                // samples: 1: a hole; only where there are some
    Store<std::uint8_t> own_;                  // places of even coordinates: own errors of steps above the finest
    Store<std::uint8_t> own_south_, own_east_; // the same on borders of regions, as measured north or west of them
    Store<std::uint32_t> level_[2];            // places of a step; [z & 1]
    Store<CentreRecord> centres_[2];           // [z & 1]
    Store<std::uint16_t> records_;             // places of step plain_z: error, radius and void_bit
    Store<std::uint32_t> plain_;               // their steps
    Store<std::uint16_t> texels_[2][2];        // [kind][mip & 1]

    HeightScale height_scale_;
    Scales scales_;
    std::optional<LeafErrors> leaf_;
    std::vector<std::unique_ptr<ImageReader>> image_readers_;
    MapPlan maps_;
    PackHeader header_{};
};

} // namespace fjell::baker
