#include "fjell/io/live_terrain.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <utility>
#include <vector>

#include "fjell/io/failure.h"
#include "fjell/io/journal.h"
#include "fjell/io/load.h"
#include "fjell/pages.h"
#include "io/file.h"
#include "io/pack_stream.h"
#include "io/quiet.h"
#include "io/stamp_blocks.h"

namespace fjell::io {

namespace {

void tell_once([[maybe_unused]] const char* line) {
#ifndef NDEBUG
    std::fputs(line, stderr);
#endif
}

} // namespace

struct LiveTerrain::Block {
    explicit Block(std::size_t size) : bytes(size), memory(allocate(size)) {}
    [[nodiscard]] std::span<std::byte> all() const { return {memory.get(), bytes}; }
    std::size_t bytes;
    AlignedMemory memory;
};
struct LiveTerrain::Kept {
    std::vector<KeptStamp> stamps;
    std::size_t next = 0;
};

CutBudget suited(CutBudget budget, const Terrain& terrain) {
    while (budget.segment_triangles > 8 && budget.triangles / budget.segment_triangles < 4 * terrain.tile_count())
        budget.segment_triangles /= 2;
    return budget;
}

LiveTerrain::LiveTerrain(const std::string& path, const LiveOptions& options)
    : settings(options.settings), options_(options), file_(std::make_unique<PackFile>(path)), pack_(file_->pack()) {
    begin(path);
}

LiveTerrain::LiveTerrain(std::span<const std::byte> pack, const std::string& name, const LiveOptions& options)
    : settings(options.settings), options_(options) {
    require(open_pack(pack, pack_), name);
    begin(name);
}

void LiveTerrain::begin(const std::string& name) {
    const PackHeader& h = pack_.header;
    if (h.order == PageOrder::linear)
        throw Failure(1, name + ": the pack is in linear order, which can be neither streamed nor kept from frame to "
                                "frame; bake it with --order planar");
    const std::uint64_t pages = std::uint64_t{tiles_of(h)} * pages_per_tile(h);
    options_.page_slots = static_cast<std::uint32_t>(std::min<std::uint64_t>(options_.page_slots, pages));
    const TerrainBudget slots{std::max(options_.page_slots, 1u)}; // 0 would be all
    terrain_block_ = std::make_unique<Block>(terrain_bytes(h, slots));
    require(file_ ? create_terrain(pack_, file_->corners(), slots, terrain_block_->all(), terrain_)
                  : create_terrain(pack_, slots, terrain_block_->all(), terrain_),
            name);
    if (!options_.journal.empty()) {
        if (!options_.edits)
            throw Failure(1, "LiveOptions::journal: needs LiveOptions::edits, which says what it may use");
        kept_ = std::make_unique<Kept>();
        kept_->stamps = Journal(options_.journal, h, JournalAccess::read).stamps();
        const bool holes = std::ranges::any_of(kept_->stamps, [](const KeptStamp& kept) {
            return kept.plain.shape == StampShape::hole || kept.plain.shape == StampShape::fill;
        });
        if (holes && !(options_.edits->holes && has_room_for_holes(h)))
            throw Failure(1, options_.journal + ": cuts holes: set EditBudget::holes, and give a pack that is baked "
                                                "with --room-for-holes yes");
        const bool locks = std::ranges::any_of(
            kept_->stamps, [](const KeptStamp& kept) { return kept.plain.shape == StampShape::lock; });
        if (locks && !has_room_for_locks(h))
            throw Failure(1, options_.journal + ": locks places: give a pack that is baked with --room-for-locks yes");
        StampBlocks blocks(h);
        for (const KeptStamp& kept : kept_->stamps) blocks.add(kept);
        options_.edits->blocks += blocks.heights(), options_.edits->paint += blocks.paint();
        options_.edits->locks += blocks.locks();
    }
    if (options_.edits) {
        edits_block_ = std::make_unique<Block>(edits_bytes(h, *options_.edits));
        require(create_edits(terrain_, *options_.edits, edits_block_->all(), edits_), name);
    }
    options_.cut = suited(options_.cut, terrain_);
    cut_block_ = std::make_unique<Block>(cut_bytes(terrain_, options_.cut));
    require(create_cut(terrain_, options_.cut, cut_block_->all(), cut_), name);
    stream_ = file_ ? std::make_unique<PackStream>(*file_) : std::make_unique<PackStream>(pack_, name);
    stream_->begin(terrain_, cut_, options_.stream, options_.reader);
}

LiveTerrain::~LiveTerrain() = default;

// As many as the queue takes. They stay, because they are pointed to until they are applied.
void LiveTerrain::push_kept() {
    for (; kept_->next < kept_->stamps.size(); ++kept_->next) {
        StampId id = 0;
        if (!push_stamp(edits_, kept_->stamps[kept_->next].stamp(), id).ok()) return;
    }
}

const LiveFrame& LiveTerrain::update(std::span<const View> views, double now_s) {
    settings.cut.now_s = settings.stream.now_s = settings.edits.now_s = now_s;
    if (!commands_taken_ && (frame_.forgotten & live_map_commands) == 0) {
        frame_.forgotten |= live_map_commands;
        tell_once("fjell: map commands were not taken before the next update, so maps show wrongly: "
                  "LiveTerrain::take_map_commands()\n");
    }
    if (kept_) push_kept();
    if (edits_block_)
        if (const Status s = update_edits(edits_, views, settings.edits, frame_.edits); !s.ok())
            throw Failure(1, std::string(s.field) + ": " + message(s.code));
    frame_.stream = stream_->update(views, settings.cut, settings.stream);
    commands_taken_ = stream_map_commands(stream_->stream()).empty();
    if (!maps_asked_for_ && frame_.stream.complete && frame_.stream.mips_read != 0 &&
        (frame_.forgotten & live_tile_maps) == 0) {
        frame_.forgotten |= live_tile_maps;
        tell_once("fjell: maps are loaded and nobody shows them: LiveTerrain::tile_maps()\n");
    }
    if (const Status s = update_cut(cut_, views, settings.cut, frame_.cut); !s.ok())
        throw Failure(1, std::string(s.field) + ": " + message(s.code));
    frame_.mesh = cut_mesh(cut_);
    frame_.converged = frame_.cut.converged && frame_.stream.converged && frame_.stream.maps_converged;
    frame_.settled = is_settled(frame_.converged, frame_.cut, frame_.stream, frame_.edits, quiet_);
    name_what_is_short();
    return frame_;
}

void LiveTerrain::name_what_is_short() {
    std::size_t count = 0;
    constexpr std::pair<std::uint32_t, const char*> of_edits[] = {{edit_budget_work, "EditSettings::max_work"},
                                                                  {edit_budget_time, "EditSettings::max_time_us"},
                                                                  {edit_budget_blocks, "EditBudget::blocks"},
                                                                  {edit_budget_paint, "EditBudget::paint"},
                                                                  {edit_budget_locks, "EditBudget::locks"}};
    for (const auto& [bit, field] : of_edits)
        if ((frame_.edits.exhausted & bit) != 0) short_of_[count++] = field;
    for (std::uint32_t left = frame_.cut.exhausted; left != 0; left &= left - 1)
        short_of_[count++] = budget_field(static_cast<CutBudgetBit>(left & -left));
    for (std::uint32_t left = frame_.stream.exhausted; left != 0; left &= left - 1)
        short_of_[count++] = budget_field(static_cast<StreamBudgetBit>(left & -left));
    frame_.short_of = std::span(short_of_).first(count);
}

std::span<const MapCommand> LiveTerrain::take_map_commands() {
    const bool taken = commands_taken_;
    commands_taken_ = true;
    return taken ? std::span<const MapCommand>() : stream_map_commands(stream_->stream());
}

std::span<const TileMap> LiveTerrain::tile_maps(MapKind kind) {
    maps_asked_for_ = true;
    return stream_tile_maps(stream_->stream(), kind);
}

Stream LiveTerrain::stream() const {
    return stream_->stream();
}

std::size_t LiveTerrain::memory_bytes() const {
    return terrain_block_->bytes + (edits_block_ ? edits_block_->bytes : 0) + cut_block_->bytes +
           stream_->memory_bytes();
}

StreamReaderCounters LiveTerrain::reader() const {
    return stream_->reader();
}

std::string LiveTerrain::first_failure() const {
    return stream_->first_failure();
}

} // namespace fjell::io
