#include "baker/shard/shard_step.h"

#include <chrono>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include <sys/resource.h>

#include "baker/bake/plan.h"
#include "baker/bake/stages.h"
#include "baker/shard/seam.h"
#include "baker/shard/shard_chunks.h"
#include "baker/shard/shard_fill.h"
#include "baker/shard/shard_ground.h"
#include "baker/shard/shard_maps.h"

namespace fjell::baker {

namespace {

using Clock = std::chrono::steady_clock;
using Kind = ShardStep::Kind;

constexpr ShardStep read_step{Kind::read}, measure_step{Kind::measure};

double cpu_seconds() {
    rusage used{};
    (void)getrusage(RUSAGE_SELF, &used);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(used.ru_utime) + seconds(used.ru_stime);
}

double resident_mb() {
    rusage used{};
    (void)getrusage(RUSAGE_SELF, &used);
    return static_cast<double>(used.ru_maxrss) / 1024;
}

class ShardRun {
public:
    ShardRun(const ShardPlan& plan, const HeightSource& source, const BakeOptions& options, int shard,
             const ShardStep& step)
        : plan_(plan), step_(step), shard_(shard), scratch_(plan, step, shard),
          context_(source, options, scratch_.file("bake"), plan.parts[static_cast<std::size_t>(shard) - 1]),
          own_(windows_of(shard)), ground_(plan, context_) {}

    void run() {
        const Clock::time_point start = Clock::now();
        const double cpu = cpu_seconds();
        if (step_.kind == Kind::read) {
            read();
        } else if (const CheckpointState found = found_by_shards(plan_, context_, step_.kind == Kind::errors);
                   find_ground(found)) {
            switch (step_.kind) {
            case Kind::read: break;
            case Kind::means: means(found); break;
            case Kind::measure: measure(found); break;
            case Kind::errors: errors(found); break;
            }
        }
        record_.seconds = std::chrono::duration<double>(Clock::now() - start).count();
        record_.cpu_seconds = cpu_seconds() - cpu;
        record_.resident_mb = resident_mb();
        scratch_.publish(record_);
    }

private:
    [[nodiscard]] PartWindows windows_of(int shard) const {
        return {context_.tree, context_.regions, plan_.parts[static_cast<std::size_t>(shard) - 1]};
    }
    // Sizes of maps alone: what lies where does not depend on heights.
    [[nodiscard]] MapPlan map_sizes() const {
        MapPlan maps;
        maps.tree = context_.tree;
        std::copy_n(context_.source.spacing_m, 2, maps.spacing_m);
        maps.colour_log2 = context_.colour_log2;
        maps.normal_log2 = context_.normal_log2;
        maps.horizon_log2 = context_.horizon_log2;
        maps.control_log2 = context_.control_log2;
        return maps;
    }

    [[nodiscard]] std::int32_t frame_of(const MapPlan& maps) const {
        return height_frame(maps, context_.options.whole_level_vertices);
    }

    // False where there is nothing to do for this shard.
    [[nodiscard]] bool find_ground(const CheckpointState& found) {
        if (!needs_all_heights(context_)) ground_.find(found.holes != 0);
        if (!ground_.leaves_out()) return true;
        context_.leave_out([&](std::int64_t region) { return ground_.bakes(region); });
        return !ground_.idles(shard_);
    }
    // A new store in the scratch folder. Of a plan for a set it takes room as it is written.
    template <typename T>
    [[nodiscard]] Store<T> make(const std::string& name, const Window& whole, const Window& held) const {
        return {scratch_.file(name), whole.columns, whole.rows, held,
                plan_.packs ? WorkFile::Room::as_written : WorkFile::Room::reserved};
    }
    [[nodiscard]] Store<float> make_heights(const std::string& name) const {
        Store<float> heights = make<float>(name, {0, 0, context_.tree.columns(), context_.tree.rows()}, own_.samples());
        if (plan_.packs) heights.unwritten_is_void();
        return heights;
    }
    template <typename T>
    void leave(const std::string& name, const Store<T>& store) {
        scratch_.add(name, store.digest());
    }
    template <typename T>
    void leave_frame(const std::string& name, const Store<T>& store, std::int32_t width_x, std::int32_t width_y) {
        scratch_.write_parcel(name + "-frame", frame_of_store(store, width_x, width_y, plan_.packs.has_value()));
    }
    // What this shard has left in an earlier step, compared with its digest.
    template <typename T>
    [[nodiscard]] Store<T> find(const ShardStep& step, const std::string& name, const Window& whole,
                                const Window& held) const {
        const ShardRecord record = require_record(plan_, step, shard_);
        const std::string path = plan_.file(step, shard_, name);
        Store<T> store = Store<T>::complete(path, whole.columns, whole.rows, held);
        if (store.digest() != record.files.at(name).digest)
            throw Failure(1, fmt::format("{}: is damaged; run {} --again", path, plan_.command(step, shard_)));
        return store;
    }
    // held_of: what a shard holds of this store, from its windows.
    template <typename T, typename HeldOf>
    void add_frames_to(Store<T>& store, const ShardStep& step, const std::string& name, std::int32_t width_x,
                       std::int32_t width_y, const HeldOf& held_of) {
        record_.seam_bytes_read += add_frames<T>(
            plan_, step, name + "-frame", shard_, width_x, width_y,
            [&](int other) {
                const bool none = step.kind == Kind::read ? ground_.is_void(other) : ground_.idles(other);
                return none ? Window{} : held_of(windows_of(other));
            },
            store, plan_.packs.has_value());
    }

    void read();
    void means(const CheckpointState& found);
    void measure(const CheckpointState& found);
    void errors(const CheckpointState& found);
    void near_maps(const BakePlan& plan, const HeightStores& heights, ChunkFile& chunks);
    void finest(const BakePlan& plan, const CheckpointState& found, ChunkFile& chunks, StepStores& step);
    void coarser(const BakePlan& plan, const CheckpointState& found, ChunkFile& chunks, StepStores& step);
    void far_mips(const BakePlan& plan, ChunkFile& chunks);
    [[nodiscard]] Store<float> find_heights(std::int32_t frame);
    [[nodiscard]] UnsaturatedStores find_unsaturated();
    [[nodiscard]] TexelStore make_texels(const MapPlan& maps, MapKind kind, std::uint32_t mip) const;
    void leave_texels(const MapPlan& maps, MapKind kind, std::uint32_t mip, const TexelStore& texels);
    [[nodiscard]] bool last_round() const { return step_.z + 1 == plan_.rounds; }

    const ShardPlan& plan_;
    const ShardStep step_;
    const int shard_;
    ScratchFolder scratch_;
    BakeContext context_;
    const PartWindows own_;
    ShardGround ground_;
    ShardRecord record_;
};

Window samples_of(const Tree& tree) {
    return {0, 0, tree.columns(), tree.rows()};
}

void ShardRun::read() {
    static_assert(sizeof(ReadStatistics) % alignof(std::uint32_t) == 0);
    static_assert(std::is_trivially_copyable_v<ReadStatistics>, "ReadStatistics goes into a parcel as it is");
    Store<float> heights = make_heights("heights");
    GroundSeen seen(context_.tree);
    ParcelWriter facts;
    if (plan_.packs) {
        facts.put(read_windows(context_, heights, [&](const Window& w, const float* h, std::ptrdiff_t stride) {
            return seen.note(w, h, stride);
        }));
        facts.put_all(std::span<const std::uint32_t>(seen.tiles()));
    } else {
        facts.put(read_windows(context_, heights));
    }
    scratch_.write_parcel("facts", facts.bytes);
    scratch_.add("heights", heights.written());
    const std::int32_t width = ShardFill::raw_frame(frame_of(map_sizes())); // in case there are voids
    leave_frame("heights", heights, width, width);
}

Store<float> ShardRun::find_heights(std::int32_t frame) {
    Store<float> heights = ground_.is_void(shard_)
                               ? make_heights("no-heights")
                               : find<float>(read_step, "heights", samples_of(context_.tree), own_.samples());
    if (plan_.packs) heights.unwritten_is_void();
    if (frame != 0)
        add_frames_to(heights, read_step, "heights", frame, frame, [](const PartWindows& w) { return w.samples(); });
    return heights;
}

void ShardRun::means(const CheckpointState& found) {
    if (!found.has_voids || ground_.is_void(shard_)) return;
    ShardFill({plan_, context_, ground_, shard_}, frame_of(map_sizes()), scratch_).leave_means(find_heights(0));
}

void ShardRun::measure(const CheckpointState& found) {
    const std::int32_t frame = frame_of(map_sizes());
    Store<float> heights;
    Store<std::uint8_t> holes;
    if (found.has_voids) {
        const ShardFill fill({plan_, context_, ground_, shard_}, frame, scratch_);
        const Store<float> raw = find_heights(ShardFill::raw_frame(frame));
        const Window all = samples_of(context_.tree), filled = fill.filled_window();
        heights = make<float>("filled", all, filled);
        record_.seam_bytes_read += fill.fill(raw, {found.native_quantum_m, found.anchor_m}, heights);
        leave("filled", heights);
        if (found.holes) {
            holes = make<std::uint8_t>("holes", all, filled);
            for (const Window& w : fill.filled_windows()) mark_voids(context_, raw, w, holes);
            leave("holes", holes);
        }
    } else {
        heights = find_heights(context_.horizon_log2 != 0 ? frame : 1);
    }
    if (context_.horizon_log2 != 0) ShardLevels(plan_, context_, shard_, frame).leave(heights, scratch_);
    if (context_.control.wants_wetness()) leave_squares(context_, heights, scratch_);
    ParcelWriter facts;
    facts.put(measure_heights(context_, {heights, holes}));
    scratch_.write_parcel("facts", facts.bytes);
}

void ShardRun::errors(const CheckpointState& found) {
    const BakePlan plan = make_plan(context_, found);
    ChunkFile chunks(scratch_.file("chunks"), plan.header);
    const int z = step_.z;
    StepStores step{make<std::uint32_t>("places", places_of(context_.tree, z + 1), own_.places(z + 1)), {}, {}};
    const Window all = places_of(context_.tree, z + 1);
    step.centres = make<CentreRecord>("centres", {0, 0, all.columns - 1, all.rows - 1}, own_.centres(z));
    if (z == 0) {
        finest(plan, found, chunks, step);
    } else {
        coarser(plan, found, chunks, step);
        far_mips(plan, chunks);
    }
    leave("places", step.places);
    leave("centres", step.centres);
    if (!last_round()) {
        leave_frame("places", step.places, step_frame, step_frame);
        leave_frame("centres", step.centres, step_frame, step_frame);
    }
    scratch_.add("chunks");
    scratch_.write_parcel("index", chunks.index());
}

void ShardRun::finest(const BakePlan& plan, const CheckpointState& found, ChunkFile& chunks, StepStores& step) {
    const std::int32_t frame = frame_of(plan.maps);
    const Window samples = samples_of(context_.tree);
    const Window filled = with_frame(own_, frame);
    const Store<float> heights =
        found.has_voids ? find<float>(measure_step, "filled", samples, filled) : find_heights(frame);
    const Store<std::uint8_t> holes =
        found.holes ? find<std::uint8_t>(measure_step, "holes", samples, filled) : Store<std::uint8_t>{};
    near_maps(plan, {heights, holes}, chunks);
    const Window all = places_of(context_.tree, 1);
    UnsaturatedStores unsaturated{
        make<std::uint8_t>("unsaturated", all, own_.places(1)),
        make<std::uint8_t>("south", {0, 0, all.columns, context_.regions.down()}, own_.south(1)),
        make<std::uint8_t>("east", {0, 0, all.rows, context_.regions.across()}, own_.east(1))};
    MixedStores none; // steps whose pages hold others too are the merge's
    ParcelWriter facts;
    facts.put(make_finest_step(context_, plan, {heights, holes}, {unsaturated, step, none, chunks}));
    scratch_.write_parcel("facts", facts.bytes);
    leave("unsaturated", unsaturated.inside);
    leave("south", unsaturated.south);
    leave("east", unsaturated.east);
    leave_frame("unsaturated", unsaturated.inside, 1, 1);
    leave_frame("south", unsaturated.south, 1, 1);
    leave_frame("east", unsaturated.east, 1, 1);
}

void ShardRun::near_maps(const BakePlan& plan, const HeightStores& heights, ChunkFile& chunks) {
    const std::uint32_t mip = mip_of_round(0);
    const MapPlan& maps = plan.maps;
    TexelStore texels[map_kind_count];
    for (const MapKind kind : all_map_kinds) texels[static_cast<int>(kind)] = make_texels(maps, kind, mip);
    make_near_maps(context_, plan, heights, {texels[0], texels[1], chunks});
    if (maps.horizon_log2 != 0) {
        ShardLevels levels(plan_, context_, shard_, frame_of(maps));
        record_.seam_bytes_read += levels.find();
        make_near_horizons(context_, plan, {heights, levels.reader()}, {texels[2], chunks});
    }
    if (maps.control_log2 != 0) {
        std::optional<Wetness> wetness;
        if (context_.control.wants_wetness()) wetness = find_wetness(plan_, context_, record_.seam_bytes_read);
        make_near_control(context_, plan, heights, wetness ? &*wetness : nullptr, {texels[3], chunks});
    }
    for (const MapKind kind : all_map_kinds) leave_texels(maps, kind, mip, texels[static_cast<int>(kind)]);
}

UnsaturatedStores ShardRun::find_unsaturated() {
    const ShardStep first{Kind::errors, 0};
    const Window all = places_of(context_.tree, 1);
    UnsaturatedStores stores{
        find<std::uint8_t>(first, "unsaturated", all, own_.places(1)),
        find<std::uint8_t>(first, "south", {0, 0, all.columns, context_.regions.down()}, own_.south(1)),
        find<std::uint8_t>(first, "east", {0, 0, all.rows, context_.regions.across()}, own_.east(1))};
    add_frames_to(stores.inside, first, "unsaturated", 1, 1, [](const PartWindows& w) { return w.places(1); });
    add_frames_to(stores.south, first, "south", 0, 1, [](const PartWindows& w) { return w.south(1); });
    add_frames_to(stores.east, first, "east", 0, 1, [](const PartWindows& w) { return w.east(1); });
    return stores;
}

void ShardRun::coarser(const BakePlan& plan, const CheckpointState& found, ChunkFile& chunks, StepStores& step) {
    const int z = step_.z;
    const ShardStep before{Kind::errors, z - 1};
    const UnsaturatedStores unsaturated = find_unsaturated();
    const Window all = places_of(context_.tree, z);
    StepStores finer{find<std::uint32_t>(before, "places", all, own_.places(z)),
                     find<CentreRecord>(before, "centres", {0, 0, all.columns - 1, all.rows - 1}, own_.centres(z - 1)),
                     {}};
    add_frames_to(finer.places, before, "places", step_frame, step_frame,
                  [&](const PartWindows& w) { return w.places(z); });
    add_frames_to(finer.centres, before, "centres", step_frame, step_frame,
                  [&](const PartWindows& w) { return w.centres(z - 1); });
    MixedStores none;
    make_coarser_step(context_, plan, {z, found.holes != 0, unsaturated, finer}, {step, none, chunks});
}

TexelStore ShardRun::make_texels(const MapPlan& maps, MapKind kind, std::uint32_t mip) const {
    if (!leaves_texels(maps, kind, mip)) return {};
    Window grid = maps.grid(kind, mip);
    grid.columns *= static_cast<std::int32_t>(channels(kind));
    return make<std::uint16_t>(texel_name(kind, mip), grid, own_.texels(maps, kind, mip));
}

void ShardRun::leave_texels(const MapPlan& maps, MapKind kind, std::uint32_t mip, const TexelStore& texels) {
    if (!leaves_texels(maps, kind, mip)) return;
    const std::string name = texel_name(kind, mip);
    leave(name, texels);
    constexpr std::int32_t width = texel_frame + 1; // the first is the border, which the neighbour has too
    if (!last_round()) leave_frame(name, texels, width * static_cast<std::int32_t>(channels(kind)), width);
}

void ShardRun::far_mips(const BakePlan& plan, ChunkFile& chunks) {
    const std::uint32_t mip = mip_of_round(step_.z);
    const ShardStep before{Kind::errors, step_.z - 1};
    for (const MapKind kind : all_map_kinds) {
        if (!leaves_texels(plan.maps, kind, mip - 1)) continue;
        Window grid = plan.maps.grid(kind, mip - 1);
        const auto n = static_cast<std::int32_t>(channels(kind));
        grid.columns *= n;
        const std::string name = texel_name(kind, mip - 1);
        TexelStore finer = find<std::uint16_t>(before, name, grid, own_.texels(plan.maps, kind, mip - 1));
        add_frames_to(finer, before, name, texel_frame * n, texel_frame,
                      [&](const PartWindows& w) { return w.texels(plan.maps, kind, mip - 1); });
        TexelStore texels = make_texels(plan.maps, kind, mip);
        make_far_mip(context_, plan, {kind, mip, finer}, {texels, chunks});
        leave_texels(plan.maps, kind, mip, texels);
    }
}

} // namespace

bool leaves_texels(const MapPlan& maps, MapKind kind, std::uint32_t mip) {
    return maps.log2_side(kind) != 0 && mip_count(maps.log2_side(kind)) > mip + 1;
}

std::string texel_name(MapKind kind, std::uint32_t mip) {
    constexpr const char* names[map_kind_count] = {"colour", "normal", "horizon", "control"};
    return names[static_cast<std::size_t>(kind)] + std::to_string(mip);
}

CheckpointState found_by_shards(const ShardPlan& plan, const BakeContext& context, bool measured) {
    ReadStatistics read;
    CheckpointState found;
    for (int shard = 1; shard <= plan.shards; ++shard) {
        if (plan.empty(shard)) continue;
        const std::vector<std::byte> bytes = read_parcel(plan, read_step, shard, "facts");
        read.add(ParcelReader(bytes).get<ReadStatistics>());
    }
    const ReadResult result = read_result(context, read);
    found.note_source(result.properties, result.has_voids);
    if (!measured) return found;
    ShardGround ground(plan, context);
    if (!needs_all_heights(context)) ground.find(found.holes != 0);
    for (int shard = 1; shard <= plan.shards; ++shard) {
        if (ground.idles(shard)) continue;
        const std::vector<std::byte> measures = read_parcel(plan, measure_step, shard, "facts");
        found.heights.add(ParcelReader(measures).get<HeightStatistics>());
    }
    found.heights.voids += ground.samples_left_out();
    return found;
}

StepDone run_shard_step(const ShardPlan& plan, const HeightSource& source, const BakeOptions& options, int shard,
                        const ShardStep& step, bool again) {
    if (shard < 1 || shard > plan.shards)
        throw Failure(2, fmt::format("shard {}: the plan has 1 to {}", shard, plan.shards));
    if (!again && find_record(plan, step, shard)) return StepDone::before;
    if (plan.empty(shard)) {
        ScratchFolder(plan, step, shard).publish({});
        return StepDone::now;
    }
    check_source(plan, source);
    ShardRun(plan, source, options, shard, step).run();
    return StepDone::now;
}

} // namespace fjell::baker
