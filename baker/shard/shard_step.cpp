#include "baker/shard/shard_step.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <sys/resource.h>

#include "baker/bake/plan.h"
#include "baker/bake/stages.h"
#include "baker/heights/fill.h"
#include "baker/shard/plan_folder.h"
#include "baker/shard/seam.h"
#include "baker/shard/shard_chunks.h"
#include "baker/shard/shard_ground.h"
#include "baker/shard/shard_maps.h"

namespace fjell::baker {

// Voids of a shard filled: the means that its own heights have, level by level (heights/fill.h), and from its own and
// its neighbours' the same membrane that a bake of the whole finds. Where a terrain has no voids none of it is done.

// Levels of means that shards make; the coarsest is small, and every shard solves it for itself.
inline constexpr int most_mean_levels = 8;

class ShardFill {
public:
    struct Of {
        const ShardPlan& plan;
        const BakeContext& context;
        const ShardGround& ground;
        int shard;
    };
    // frame: how many samples around its own a shard fills.
    ShardFill(const Of& of, std::int32_t frame, ScratchFolder& scratch);

    [[nodiscard]] Window filled_window() const { return needs_.front(); }
    // All of it, or what regions that are baked need. They do not overlap.
    [[nodiscard]] const std::vector<Window>& filled_windows() const { return pieces_.front(); }
    // What a frame of raw heights must be wide.
    [[nodiscard]] static constexpr std::int32_t raw_frame(std::int32_t frame) { return frame + fill_halo; }

    // Step `means`: stores, their frames, and the coarsest level as a parcel. raw: this shard's own heights.
    void leave_means(const Store<float>& raw);
    // raw: with raw_frame() around it. out: fills filled_windows(). Returns the bytes of other shards that were read.
    std::uint64_t fill(const Store<float>& raw, const FillStep& step, Store<float>& out) const;

private:
    [[nodiscard]] Window held_of(int shard, std::size_t level) const;
    [[nodiscard]] Window halved(const Window& samples, std::size_t level) const;
    [[nodiscard]] std::vector<Window> regions_with_ground() const;
    void find_pieces(std::int32_t frame);
    [[nodiscard]] Store<float> make_level(const std::string& path, std::size_t level, const Window& held) const;
    [[nodiscard]] Store<float> find_means(std::size_t level) const;
    [[nodiscard]] Store<float> gather_coarsest() const;

    const ShardPlan& plan_;
    const BakeContext& context_;
    const ShardGround& ground_;
    const int shard_;
    const std::int32_t mean_frame_; // of the coarser levels
    ScratchFolder& scratch_;
    std::vector<Window> levels_;              // the whole of each: level 0 are the samples
    std::vector<Window> needs_;               // of each: what is filled here
    std::vector<std::vector<Window>> pieces_; // of each, in it
};

namespace {

constexpr ShardStep means_step{ShardStep::Kind::means};

std::string mean_name(std::size_t level) {
    return fmt::format("means{}", level);
}

} // namespace

ShardFill::ShardFill(const Of& of, std::int32_t frame, ScratchFolder& scratch)
    : plan_(of.plan), context_(of.context), ground_(of.ground), shard_(of.shard),
      // What is filled around a part becomes half as wide with each level, and half the halo and a little wider: 24 at
      // most, or little more than half of the first.
      mean_frame_(std::max(frame / 2 + 12, 24) + fill_halo),
      scratch_(scratch), levels_{{0, 0, of.context.tree.columns(), of.context.tree.rows()}} {
    while (levels_.size() <= most_mean_levels && (levels_.back().columns > 1 || levels_.back().rows > 1))
        levels_.push_back({0, 0, (levels_.back().columns + 1) / 2, (levels_.back().rows + 1) / 2});
    needs_.push_back(with_frame({context_.tree, context_.regions, context_.region_window()}, frame));
    for (std::size_t level = 1; level < levels_.size(); ++level)
        needs_.push_back(seen_coarser(needs_.back(), levels_[level - 1], levels_[level]));
    find_pieces(frame);
}

// Where regions are left out: pieces of each level that the ones that are baked look at, a few samples more.
void ShardFill::find_pieces(std::int32_t frame) {
    if (!ground_.leaves_out()) {
        for (const Window& all : needs_) pieces_.push_back({all});
        return;
    }
    constexpr std::int32_t side = 256;
    std::vector<Window> wanted;
    for (std::uint64_t u = 0; u < context_.region_count(); ++u) {
        const auto region = static_cast<std::int32_t>(context_.region_at(u)), across = context_.regions.across();
        wanted.push_back(
            with_frame({context_.tree, context_.regions, {region % across, region / across, 1, 1}}, frame));
    }
    for (std::size_t level = 0; level < needs_.size(); ++level) {
        const Window& all = needs_[level];
        const std::int32_t across = (all.columns - 1) / side + 1, down = (all.rows - 1) / side + 1;
        std::vector<bool> looked_at(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
        for (const Window& want : wanted) {
            const Window w = common(want, all);
            if (w.area() == 0) continue;
            for (std::int32_t y = (w.y - all.y) / side; y <= (w.y - all.y + w.rows - 1) / side; ++y)
                for (std::int32_t x = (w.x - all.x) / side; x <= (w.x - all.x + w.columns - 1) / side; ++x)
                    looked_at[static_cast<std::size_t>(y) * static_cast<std::size_t>(across) +
                              static_cast<std::size_t>(x)] = true;
        }
        std::vector<Window> pieces;
        for (std::size_t i = 0; i < looked_at.size(); ++i)
            if (looked_at[i])
                pieces.push_back(common({all.x + static_cast<std::int32_t>(i) % across * side,
                                         all.y + static_cast<std::int32_t>(i) / across * side, side, side},
                                        all));
        wanted.clear();
        for (const Window& piece : pieces)
            if (level + 1 < needs_.size()) wanted.push_back(seen_coarser(piece, levels_[level], levels_[level + 1]));
        pieces_.push_back(std::move(pieces));
    }
}

// Parts begin at multiples of 2^most_mean_levels, so that no mean lies in two of them.
Window ShardFill::held_of(int shard, std::size_t level) const {
    return halved(context_.regions.samples_of(plan_.parts[static_cast<std::size_t>(shard) - 1]), level);
}

Window ShardFill::halved(const Window& samples, std::size_t level) const {
    const std::int32_t unit = 1 << level;
    const auto end = [&](std::int32_t last) { return (last + unit - 1) / unit; };
    const std::int32_t x = samples.x / unit, y = samples.y / unit;
    return {x, y, end(samples.x + samples.columns) - x, end(samples.y + samples.rows) - y};
}

// Of this shard, their samples. Regions begin where parts may.
std::vector<Window> ShardFill::regions_with_ground() const {
    std::vector<Window> all;
    for (std::uint64_t u = 0; u < context_.region_count(); ++u) {
        const auto region = static_cast<std::int32_t>(context_.region_at(u)), across = context_.regions.across();
        const Window part{region % across, region / across, 1, 1};
        if (ground_.in_tiles(context_.regions.tiles_of(part))) all.push_back(context_.regions.samples_of(part));
    }
    return all;
}

Store<float> ShardFill::make_level(const std::string& path, std::size_t level, const Window& held) const {
    const bool sparse = ground_.leaves_out();
    return {path, levels_[level].columns, levels_[level].rows, held,
            sparse ? WorkFile::Room::as_written : WorkFile::Room::reserved};
}

void ShardFill::leave_means(const Store<float>& raw) {
    const int threads = context_.workers_for(fill_piece_bytes);
    const Window own = context_.sample_window();
    std::vector<Store<float>> means;
    for (std::size_t level = 1; level < levels_.size(); ++level) {
        const Window held = held_of(shard_, level);
        means.push_back(make_level(scratch_.file(mean_name(level)), level, held));
        if (ground_.leaves_out()) means.back().unwritten_is_void();
        for (const Window& w : ground_.leaves_out() ? regions_with_ground() : std::vector{own})
            (void)halve_heights(level == 1 ? raw : means[level - 2], halved(w, level), threads, means.back());
        scratch_.write_parcel(mean_name(level) + "-frame",
                              frame_of_store(means.back(), mean_frame_, mean_frame_, ground_.leaves_out()));
        scratch_.add(mean_name(level), means.back().digest());
    }
    const Window held = held_of(shard_, levels_.size() - 1);
    std::vector<float> coarsest(held.area());
    (means.empty() ? raw : means.back()).read(held, coarsest.data(), held.columns);
    ParcelWriter parcel;
    parcel.put_all(std::span<const float>(coarsest));
    scratch_.write_parcel("coarsest", parcel.bytes);
}

Store<float> ShardFill::gather_coarsest() const {
    const std::size_t level = levels_.size() - 1;
    const Window& all = levels_[level];
    Store<float> means("", all.columns, all.rows);
    if (ground_.leaves_out()) means.unwritten_is_void();
    for (int shard = 1; shard <= plan_.shards; ++shard) {
        if (plan_.empty(shard) || ground_.is_void(shard)) continue;
        const Window held = held_of(shard, level);
        const std::vector<std::byte> bytes = read_parcel(plan_, means_step, shard, "coarsest");
        std::vector<float> values(held.area());
        ParcelReader(bytes).get_all(std::span(values));
        means.write(held, values.data(), held.columns);
    }
    return means;
}

Store<float> ShardFill::find_means(std::size_t level) const {
    const Window& all = levels_[level];
    const std::string name = mean_name(level), path = plan_.file(means_step, shard_, name);
    if (ground_.is_void(shard_)) {
        Store<float> none = make_level(scratch_.file("no-" + name), level, held_of(shard_, level));
        none.unwritten_is_void();
        return none;
    }
    const ShardRecord record = require_record(plan_, means_step, shard_);
    Store<float> means = Store<float>::complete(path, all.columns, all.rows, held_of(shard_, level));
    if (means.digest() != record.files.at(name).digest) throw Failure(1, plan_.damage(means_step, shard_, path));
    if (ground_.leaves_out()) means.unwritten_is_void();
    return means;
}

std::uint64_t ShardFill::fill(const Store<float>& raw, const FillStep& step, Store<float>& out) const {
    const int threads = context_.workers_for(fill_piece_bytes);
    const std::size_t top = levels_.size() - 1;
    const Store<float> coarsest = gather_coarsest();
    std::uint64_t bytes_read = levels_[top].area() * sizeof(float);
    Store<float> filled("", levels_[top].columns, levels_[top].rows);
    fill_voids(
        {coarsest,
         {},
         threads,
         [](const std::string&, std::int64_t columns, std::int64_t rows) { return Store<float>("", columns, rows); }},
        filled);
    for (std::size_t level = top - 1; level > 0; --level) {
        Store<float> means = find_means(level);
        bytes_read += add_frames<float>(
            plan_, means_step, mean_name(level) + "-frame", shard_, mean_frame_, mean_frame_,
            [&](int other) { return ground_.is_void(other) ? Window{} : held_of(other, level); }, means,
            ground_.leaves_out());
        Store<float> to = make_level(scratch_.file("filling" + std::to_string(level)), level, needs_[level]);
        for (const Window& w : pieces_[level]) fill_level(means, filled, {}, w, threads, to);
        filled.remove();
        filled = std::move(to);
    }
    for (const Window& w : pieces_.front()) fill_level(raw, filled, step, w, threads, out);
    filled.remove();
    return bytes_read;
}

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
        maps.splat_log2 = context_.splat_log2;
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
        if (store.digest() != record.files.at(name).digest) throw Failure(1, plan_.damage(step, shard_, path));
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
    if (context_.splat.wants_wetness()) leave_squares(context_, heights, scratch_);
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
    const FinestStepResult made = make_finest_step(context_, plan, {heights, holes}, {unsaturated, step, none, chunks});
    ParcelWriter facts;
    facts.put(made.always_drawn);
    facts.put(made.ground_error_m);
    facts.put(static_cast<std::uint32_t>(made.on_scale));
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
    if (maps.splat_log2 != 0) {
        std::optional<Wetness> wetness;
        if (context_.splat.wants_wetness()) wetness = find_wetness(plan_, context_, record_.seam_bytes_read);
        make_near_splat(context_, plan, heights, wetness ? &*wetness : nullptr, {texels[3], chunks});
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
    ParcelWriter facts;
    facts.put(make_coarser_step(context_, plan, {z, found.holes != 0, unsaturated, finer}, {step, none, chunks}));
    scratch_.write_parcel("facts", facts.bytes);
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
    constexpr const char* names[map_kind_count] = {"colour", "normal", "horizon", "splat"};
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
