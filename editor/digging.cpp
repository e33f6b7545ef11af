#include "editor/digging.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

#include "baker/read/edited_source.h"
#include "baker/read/pack_source.h"
#include "editor/document.h"
#include "fjell/io/failure.h"
#include "fjell/io/pack_file.h"
#include "io/stamps.h"
#include "io/system.h"
#include "shared/stamp.h"

namespace fjell::editor {

namespace {

using edit::Rect;

constexpr std::int64_t most_renewed = std::int64_t{1} << 20; // samples of one stamp

edit::StampGrid grid_of(const PackHeader& h) {
    return {static_cast<std::int32_t>(h.columns), static_cast<std::int32_t>(h.rows), h.spacing_m};
}

// Where heights may be others than before `changed` came or went. stamps: all that apply.
std::vector<Rect> areas_of(const edit::StampGrid& grid, std::span<const io::KeptStamp> changed,
                           std::span<const io::KeptStamp> stamps) {
    std::vector<Rect> areas; // those that meet are one
    Rect whole;
    for (const io::KeptStamp& stamp : changed) {
        Rect area = edit::samples_of(grid, stamp.stamp());
        if (area.empty() || !edit::moves_ground(stamp.plain.shape)) continue;
        for (const io::KeptStamp& smooths : stamps) // what is smoothed depends on its neighbours
            if (smooths.plain.shape == StampShape::smooth &&
                edit::samples_of(grid, smooths.stamp()).meets(area.grown(1)))
                area = area.grown(1).within({0, 0, grid.columns - 1, grid.rows - 1});
        whole = whole.with(area);
        for (std::size_t i = 0; i < areas.size();) {
            if (!areas[i].meets(area)) {
                ++i;
                continue;
            }
            area = area.with(areas[i]);
            areas.erase(areas.begin() + static_cast<std::ptrdiff_t>(i));
            i = 0;
        }
        areas.push_back(area);
    }
    // As one stamp if that is not too large: ground that is between what was and what will be need not fit a page.
    if (std::int64_t{whole.columns()} * whole.rows() <= most_renewed && !whole.empty()) return {whole};
    return areas;
}

// Those heights as a stamp, and one of what is a hole and what is not where holes may have come or gone.
void add_ground(std::vector<io::KeptStamp>& to, baker::HeightReader& reader, const Rect& area, bool holes) {
    io::KeptStamp ground;
    ground.plain.shape = StampShape::heights;
    ground.plain.first = {area.x0, area.y0};
    ground.plain.columns = area.columns(), ground.plain.rows = area.rows();
    ground.heights_m.resize(static_cast<std::size_t>(area.columns()) * static_cast<std::size_t>(area.rows()));
    baker::ReadStatistics ignored;
    reader.read({area.x0, area.y0, area.columns(), area.rows()}, ground.heights_m.data(), ignored);
    if (!holes) return to.push_back(std::move(ground));
    io::KeptStamp fill, cut;
    fill.plain = cut.plain = ground.plain;
    fill.plain.shape = StampShape::fill, cut.plain.shape = StampShape::hole;
    for (const float height_m : ground.heights_m) {
        fill.mask.push_back(std::isnan(height_m) ? 0 : 255);
        cut.mask.push_back(std::isnan(height_m) ? 255 : 0);
    }
    to.push_back(std::move(fill));
    to.push_back(std::move(ground));
    to.push_back(std::move(cut));
}

// What a pack's ground is with `stamps`, as heights of where `changed` may matter. So no ground on the way has to fit
// the pack's scales, as it would stamp by stamp.
std::vector<io::KeptStamp> ground_of(const std::string& pack, const PackHeader& header,
                                     const std::vector<io::KeptStamp>& stamps, std::span<const io::KeptStamp> changed) {
    const auto is_of_holes = [](const io::KeptStamp& stamp) { return edit::makes_or_fills_holes(stamp.plain.shape); };
    const bool holes = std::ranges::any_of(changed, is_of_holes) || std::ranges::any_of(stamps, is_of_holes);
    std::vector<io::TimedStamp> timed;
    for (const io::KeptStamp& stamp : stamps) timed.push_back({0, stamp});
    std::unique_ptr<baker::HeightSource> source = std::make_unique<baker::PackSource>(pack);
    if (!timed.empty()) source = baker::edited_source(std::move(source), timed, pack);
    const auto reader = source->reader();
    std::vector<io::KeptStamp> ground;
    for (const Rect& area : areas_of(grid_of(header), changed, stamps)) {
        const auto rows = static_cast<std::int32_t>(
            std::clamp<std::int64_t>(most_renewed / area.columns(), 1, std::int64_t{area.rows()}));
        for (std::int32_t y = area.y0; y <= area.y1; y += rows)
            add_ground(ground, *reader, {area.x0, y, area.x1, std::min(y + rows - 1, area.y1)}, holes);
    }
    return ground;
}

} // namespace

Stamp dab_of(const Brush& brush, double x_m, double z_m, double level_m, std::uint32_t seed) {
    constexpr StampShape shapes[] = {StampShape::restore, StampShape::raise, StampShape::raise,  StampShape::level,
                                     StampShape::smooth,  StampShape::noise, StampShape::crater, StampShape::restore,
                                     StampShape::hole,    StampShape::fill,  StampShape::path,   StampShape::paint,
                                     StampShape::unpaint, StampShape::lock,  StampShape::unlock};
    static_assert(std::size(shapes) == std::size(brush_tool_names), "a brush was added: say what it does");
    Stamp s;
    s.shape = shapes[static_cast<std::size_t>(brush.tool)];
    s.x_m = x_m, s.z_m = z_m;
    s.radius_m = static_cast<float>(brush.radius_m), s.falloff_m = static_cast<float>(falloff_of(brush));
    s.amount_m = static_cast<float>(brush.tool == BrushTool::lower  ? -brush.amount_m
                                    : brush.tool == BrushTool::lock ? brush.error_m
                                                                    : brush.amount_m);
    s.height_m = static_cast<float>(level_m);
    s.wavelength_m = static_cast<float>(std::max(brush.radius_m, least_brush_m));
    s.seed = seed;
    s.strength = static_cast<float>(brush.strength);
    std::copy_n(brush.rgb, 3, s.rgb);
    s.material = brush.material;
    return s;
}

io::KeptStamp road_of(const Brush& brush, std::span<const StampPoint> places) {
    io::KeptStamp road;
    road.plain = dab_of(brush, places[0].x_m, places[0].z_m, 0, 0);
    const std::size_t most = max_path_points, count = std::min(places.size(), most);
    for (std::size_t i = 0; i < count; ++i)
        road.points.push_back(places[count < 2 ? 0 : i * (places.size() - 1) / (count - 1)]);
    // Means of neighbours, until bumps shorter than some four times the road's half width are gone.
    double long_m = 0;
    for (std::size_t i = 1; i < count; ++i)
        long_m += std::hypot(road.points[i].x_m - road.points[i - 1].x_m, road.points[i].z_m - road.points[i - 1].z_m);
    const double apart_m = std::max(long_m / static_cast<double>(std::max<std::size_t>(count - 1, 1)), least_brush_m);
    const double wide = std::min(2 * brush.radius_m / apart_m, 16.0);
    const auto passes = static_cast<int>(2 * wide * wide); // the variance of a pass is a half
    for (int pass = 0; pass < passes; ++pass) {
        float before = road.points[0].height_m;
        for (std::size_t i = 1; i + 1 < count; ++i) {
            const float own = road.points[i].height_m;
            road.points[i].height_m = 0.25F * before + 0.5F * own + 0.25F * road.points[i + 1].height_m;
            before = own;
        }
    }
    return road;
}

void open_with_journal(session::FlightOptions& options) {
    options.editable = true;
    options.edit_budget = {.blocks = 4096, .stamps = 1024, .paint = 1024, .locks = 4096};
    const std::string path = io::journal_path(options.pack);
    if (!io::is_journal(path)) return;
    try {
        const PackHeader header = io::PackFile(options.pack).pack().header;
        if (header.tiles_held != 0) return;
        const std::vector<io::KeptStamp> stamps = io::Journal(path, header, io::JournalAccess::read).stamps();
        for (io::KeptStamp& ground : ground_of(options.pack, header, stamps, stamps))
            options.stamps.push_back({0, std::move(ground)});
        for (const io::KeptStamp& stamp : stamps)
            if (!edit::moves_ground(stamp.plain.shape)) options.stamps.push_back({0, stamp});
    } catch (const io::Failure&) { // Digging finds the same
    }
}

Digging::Digging(std::string pack, const PackHeader& header)
    : pack_(std::move(pack)), path_(io::journal_path(pack_)), header_(header) {
    io::os::FileInfo there;
    if (!io::os::look(path_, there)) return;
    try {
        if (const std::uint64_t bytes = journal().dropped_bytes(); bytes != 0)
            notice_ = fmt::format("{}: left out {} bytes of an incomplete record at its end", path_, bytes);
    } catch (const io::Failure& failure) {
        problem_ = failure.what();
    }
}

// Made for the first change.
io::Journal& Digging::journal() {
    if (!problem_.empty()) throw io::Failure(1, problem_);
    if (!journal_) journal_ = std::make_unique<io::Journal>(path_, header_);
    return *journal_;
}

std::span<const io::JournalLayer> Digging::layers() const {
    return journal_ ? journal_->layers() : std::span<const io::JournalLayer>();
}

std::size_t Digging::place_of(std::uint32_t layer) const {
    const auto all = layers();
    return static_cast<std::size_t>(std::ranges::find(all, layer, &io::JournalLayer::id) - all.begin());
}

std::optional<std::size_t> Digging::chosen() const {
    if (layers().empty()) return {};
    const std::size_t place = place_of(chosen_);
    return place < layers().size() ? place : layers().size() - 1;
}

void Digging::choose(std::size_t place) {
    if (place >= layers().size()) throw io::Failure(2, fmt::format("there are {} edit layers", layers().size()));
    chosen_ = layers()[place].id;
    ++version_;
}

void Digging::dab(const Stamp& stamp) {
    if (edits_ == nullptr)
        throw io::Failure(1, problem_.empty() ? "this terrain's ground cannot be changed: it lacks tiles" : problem_);
    if (const Status status = check_stamp(stamp); !status.ok())
        throw io::Failure(2, fmt::format("{}: {}", status.field, message(status.code)));
    if (edit::makes_or_fills_holes(stamp.shape) && !edits_->budget().holes)
        throw io::Failure(2, "this pack has no room for holes; bake it with --room-for-holes yes");
    if (stamp.shape == StampShape::lock && !has_room_for_locks(header_))
        throw io::Failure(2, "this pack has no room for locks; bake it with --room-for-locks yes");
    io::Journal& to = journal();
    if (layers().empty()) add_layer("ground"), made_layer_ = true;
    const io::JournalLayer& layer = to.layers()[*chosen()];
    if (!layer.on)
        throw io::Failure(2, fmt::format("the edit layer \"{}\" is off; switch it on, or choose another", layer.name));
    stroke_.emplace_back(stamp);
    // Above the others nothing has to be made anew.
    if (*chosen() + 1 == layers().size()) {
        io::KeptStamp shown = stroke_.back();
        shown.plain.strength *= layer.strength;
        edits_->push(std::move(shown));
    }
}

void Digging::end_stroke() {
    if (stroke_.empty()) return;
    const std::size_t place = *chosen();
    Step step;
    step.with_before = std::exchange(made_layer_, false);
    step.layer = layers()[place].id;
    step.stamps = std::exchange(stroke_, {});
    try {
        const std::uint64_t first = journal().add_stamps(step.layer, step.stamps);
        journal().commit();
        for (std::size_t i = 0; i < step.stamps.size(); ++i) step.ids.push_back(first + i);
    } catch (...) {
        renew(step.stamps); // as it was
        throw;
    }
    if (place + 1 != layers().size()) renew(step.stamps);
    did(std::move(step));
}

void Digging::did(Step step) {
    ++version_;
    step.stamp = next_edit_stamp();
    undo_.push_back(std::move(step));
    redo_.clear();
    last_ = Last::step;
}

void Digging::add_layer(const std::string& name) {
    end_stroke();
    const std::uint32_t id = journal().add_layer(name);
    journal().commit();
    chosen_ = id;
    Step step;
    step.after = LayerState{journal().layers().back(), journal().layers().size() - 1};
    did(std::move(step));
}

void Digging::set_layer(std::size_t place, std::optional<bool> on, std::optional<double> strength,
                        std::optional<std::size_t> to_place) {
    end_stroke();
    const std::size_t to = to_place.value_or(place);
    if (place >= layers().size() || to >= layers().size())
        throw io::Failure(2, fmt::format("there are {} edit layers", layers().size()));
    Step step;
    const auto without_stamps = [](const io::JournalLayer& of) {
        return io::JournalLayer{of.id, of.name, of.on, of.strength, {}};
    };
    step.before = LayerState{without_stamps(layers()[place]), place};
    io::JournalLayer layer = step.before->layer;
    layer.on = on.value_or(layer.on);
    layer.strength = static_cast<float>(strength.value_or(static_cast<double>(layer.strength)));
    journal().set_layer(layer, to);
    journal().commit();
    step.after = LayerState{layer, to};
    renew_layer(layers()[to]);
    did(std::move(step));
}

void Digging::remove_layer(std::size_t place) {
    end_stroke();
    if (place >= layers().size()) throw io::Failure(2, fmt::format("there are {} edit layers", layers().size()));
    Step step;
    step.before = LayerState{layers()[place], place};
    journal().remove_layer(step.before->layer.id);
    journal().commit();
    renew_layer(step.before->layer);
    did(std::move(step));
}

// From one state of a layer to the other. One that comes again has another id, and so have its stamps: other steps that
// speak of it follow.
void Digging::put_layer(std::optional<LayerState>& from, std::optional<LayerState>& to) {
    if (!to) {
        from->layer = layers()[place_of(from->layer.id)]; // with what strokes have added and other steps taken back
        journal().remove_layer(from->layer.id);
        renew_layer(from->layer);
    } else if (from) {
        journal().set_layer(to->layer, to->place);
        renew_layer(layers()[to->place]);
    } else {
        const std::uint32_t before = to->layer.id, id = journal().add_layer(to->layer.name);
        std::vector<io::KeptStamp> stamps;
        std::unordered_map<std::uint64_t, std::uint64_t> renamed;
        for (const io::JournalStamp& stamp : to->layer.stamps) stamps.push_back(stamp.what);
        const std::uint64_t first = journal().add_stamps(id, stamps);
        for (std::size_t i = 0; i < stamps.size(); ++i) renamed[to->layer.stamps[i].id] = first + i;
        to->layer.id = id;
        journal().set_layer({id, to->layer.name, to->layer.on, to->layer.strength, {}}, to->place);
        renew_layer(layers()[to->place]);
        if (chosen_ == before) chosen_ = id;
        for (std::vector<Step>* const steps : {&undo_, &redo_})
            for (Step& step : *steps) {
                if (step.layer == before) step.layer = id;
                for (std::optional<LayerState>* const state : {&step.before, &step.after})
                    if (*state && (*state)->layer.id == before) (*state)->layer.id = id;
                for (std::uint64_t& stamp : step.ids)
                    if (const auto found = renamed.find(stamp); found != renamed.end()) stamp = found->second;
            }
    }
    journal().commit();
}

void Digging::take_back(Step& step) {
    if (step.before || step.after) return put_layer(step.after, step.before);
    journal().remove_stamps(step.ids);
    journal().commit();
    step.ids.clear();
    renew(step.stamps);
}

// On top of its layer, where it was: what came after it has been taken back before.
void Digging::repeat(Step& step) {
    if (step.before || step.after) return put_layer(step.before, step.after);
    const std::uint64_t first = journal().add_stamps(step.layer, step.stamps);
    journal().commit();
    for (std::size_t i = 0; i < step.stamps.size(); ++i) step.ids.push_back(first + i);
    renew(step.stamps);
}

// The last step of the one list becomes the last of the other, or stays where it is if that fails.
void Digging::pass(std::vector<Step>& from, std::vector<Step>& to, void (Digging::*how)(Step&), Last last) {
    end_stroke();
    if (from.empty()) return;
    ++version_;
    Step step = std::move(from.back());
    from.pop_back();
    try {
        (this->*how)(step);
    } catch (...) {
        from.push_back(std::move(step));
        throw;
    }
    to.push_back(std::move(step));
    last_ = last;
}

void Digging::undo() {
    end_stroke();
    const bool again = undo_.size() > 1 && undo_.back().with_before;
    pass(undo_, redo_, &Digging::take_back, Last::undo);
    if (again) pass(undo_, redo_, &Digging::take_back, Last::undo);
}

void Digging::redo() {
    pass(redo_, undo_, &Digging::repeat, Last::redo);
    if (!redo_.empty() && redo_.back().with_before) pass(redo_, undo_, &Digging::repeat, Last::redo);
}

void Digging::take_back_refused() {
    if (in_stroke()) end_stroke();
    switch (std::exchange(last_, Last::nothing)) {
    case Last::nothing: return;
    case Last::step:
        undo();
        redo_.clear();
        break;
    case Last::redo: undo(); break;
    case Last::undo: redo(); break;
    }
    last_ = Last::nothing; // what was there is not refused for what it is
}

void Digging::renew_layer(const io::JournalLayer& layer) {
    std::vector<io::KeptStamp> stamps;
    for (const io::JournalStamp& stamp : layer.stamps) stamps.push_back(stamp.what);
    renew(stamps);
}

// Paint mixes with what is below it, and locks that are taken away may lie over others. So what lies on an area is
// taken off and laid again, with all that meets it.
void Digging::renew_over(std::span<const io::KeptStamp> changed, bool (&is)(StampShape), StampShape bare_shape) {
    const edit::StampGrid grid = grid_of(header_);
    Rect all;
    for (const io::KeptStamp& stamp : changed)
        if (is(stamp.plain.shape)) all = all.with(edit::samples_of(grid, stamp.stamp()));
    if (all.empty()) return;
    std::vector<io::KeptStamp> stamps = journal().stamps();
    std::erase_if(stamps, [&](const io::KeptStamp& stamp) { return !is(stamp.plain.shape); });
    std::vector<bool> again(stamps.size());
    for (bool grown = true; grown;) {
        grown = false;
        for (std::size_t i = 0; i < stamps.size(); ++i) {
            const Rect of_stamp = edit::samples_of(grid, stamps[i].stamp());
            if (again[i] || of_stamp.empty() || !of_stamp.meets(all)) continue;
            again[i] = grown = true;
            all = all.with(of_stamp);
        }
    }
    io::KeptStamp bare;
    bare.plain.shape = bare_shape;
    bare.plain.first = {all.x0, all.y0};
    bare.plain.columns = all.columns(), bare.plain.rows = all.rows();
    edits_->push(std::move(bare));
    for (std::size_t i = 0; i < stamps.size(); ++i)
        if (again[i]) edits_->push(std::move(stamps[i]));
}

// The samples that these stamps may change get what the journal makes of them now.
void Digging::renew(std::span<const io::KeptStamp> changed) {
    if (edits_ == nullptr || changed.empty()) return;
    renew_over(changed, edit::paints, StampShape::unpaint);
    renew_over(changed, edit::locks, StampShape::unlock);
    for (io::KeptStamp& stamp : ground_of(pack_, header_, journal().stamps(), changed)) edits_->push(std::move(stamp));
}

} // namespace fjell::editor
