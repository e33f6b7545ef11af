#include "fjell/live_c.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "fjell/io/failure.h"
#include "fjell/io/journal.h"
#include "fjell/io/live_terrain.h"
#include "fjell/profile.h"
#include "fjell/profile/keys.h"
#include "io/system.h"
#include "shared/c_convert.h"

using namespace fjell;
using namespace fjell::c_api;

static_assert(std::uint32_t{FJELL_LIVE_MAP_COMMANDS} == io::live_map_commands);
static_assert(std::uint32_t{FJELL_LIVE_TILE_MAPS} == io::live_tile_maps);

struct FjellLive {
    FjellLive(const FjellLiveOptions& o, const Profile& with, const io::LiveOptions& opened)
        : profile(with),
          terrain(o.path != nullptr ? io::LiveTerrain(o.path, opened)
                                    : io::LiveTerrain(span_of(static_cast<const std::byte*>(o.pack), o.pack_bytes),
                                                      "the pack in memory", opened)) {}
    Profile profile;
    io::LiveTerrain terrain;
    std::string journal_path;             // empty: none
    std::unique_ptr<io::Journal> journal; // from the first stamps that are kept
};

namespace {

constexpr FjellStatus no_object{FJELL_INVALID_HANDLE, "live"};

void tell(const char* line, char* why, std::size_t bytes) {
    if (why == nullptr || bytes == 0) return;
    const std::size_t length = std::min(std::strlen(line), bytes - 1);
    std::memcpy(why, line, length);
    why[length] = 0;
}

// Whatever is thrown is a line.
template <typename Body>
bool attempt(char* why, std::size_t bytes, const Body& body) {
    tell("", why, bytes);
    try {
        body();
        return true;
    } catch (const std::exception& thrown) {
        tell(io::as_failure(thrown).what(), why, bytes);
        return false;
    }
}

Profile profile_of(const FjellLiveOptions& o) {
    Profile profile = o.profile != nullptr        ? read_profile(o.profile)
                      : o.profile_text != nullptr ? parse_profile(o.profile_text, "profile_text")
                                                  : Profile{};
    for (const FjellProfileKey& key : span_of(o.keys, o.key_count)) {
        if (key.key == nullptr || key.value == nullptr) throw io::Failure(1, "keys: a key or a value is NULL");
        set_profile_key(profile, key.key, key.value);
    }
    return profile;
}

} // namespace

FjellLive* fjell_live_open(const FjellLiveOptions* options, char* why, size_t why_bytes) {
    FjellLive* live = nullptr;
    (void)attempt(why, why_bytes, [&] {
        FjellLiveOptions o{};
        if (options == nullptr || options->struct_size < sizeof o.struct_size || options->struct_size > sizeof o)
            throw io::Failure(1, "FjellLiveOptions::struct_size: set it to sizeof the struct");
        std::memcpy(&o, options, static_cast<std::size_t>(options->struct_size));
        if ((o.path != nullptr) == (o.pack != nullptr))
            throw io::Failure(1, "FjellLiveOptions: give a path, or a pack in memory");
        const In edits(o.edits);
        if (!edits.ok) throw io::Failure(1, "FjellEditBudget::struct_size: set it to sizeof the struct");
        const Profile profile = profile_of(o);
        io::LiveOptions opened = live_options(profile);
        if (o.edits != nullptr) opened.edits = edits.value;
        if (o.journal != nullptr && o.edits == nullptr)
            throw io::Failure(1, "FjellLiveOptions::journal: needs edits, which says what it may use");
        if (o.journal != nullptr && std::filesystem::exists(io::os::path_of(o.journal))) opened.journal = o.journal;
        live = new FjellLive(o, profile, opened);
        if (o.journal != nullptr) live->journal_path = o.journal;
    });
    return live;
}
void fjell_live_close(FjellLive* live) {
    delete live;
}
bool fjell_live_set(FjellLive* live, FjellProfileKey key, char* why, size_t why_bytes) {
    return attempt(why, why_bytes, [&] {
        if (live == nullptr || key.key == nullptr || key.value == nullptr)
            throw io::Failure(1, "fjell_live_set: NULL is no object, key or value");
        Profile changed = live->profile;
        set_profile_key(changed, key.key, key.value);
        if (find_profile_key(key.key)->rebuild != Rebuild::nothing)
            throw io::Failure(1, std::string(key.key) +
                                     ": is fixed at opening; close the terrain and open it with the key");
        live->profile = changed;
        live->terrain.settings.cut = cut_settings(changed, 0);
        live->terrain.settings.stream = stream_settings(changed, 0);
    });
}

bool fjell_live_keep_stamps(FjellLive* live, const char* layer, const FjellStamp* stamps, size_t stamp_count, char* why,
                            size_t why_bytes) {
    return attempt(why, why_bytes, [&] {
        if (live == nullptr || layer == nullptr || (stamps == nullptr && stamp_count != 0))
            throw io::Failure(1, "fjell_live_keep_stamps: NULL is no object, layer or stamp");
        if (live->journal_path.empty()) throw io::Failure(1, "fjell_live_keep_stamps: needs FjellLiveOptions::journal");
        std::vector<io::KeptStamp> kept;
        for (std::size_t i = 0; i < stamp_count; ++i) {
            const In stamp(&stamps[i]);
            if (!stamp.ok) throw io::Failure(1, "FjellStamp::struct_size: set it to sizeof the struct");
            if (const Status status = check_stamp(stamp.value); !status.ok())
                throw io::Failure(1, std::string(status.field) + ": " + message(status.code));
            kept.emplace_back(stamp.value);
        }
        if (live->journal == nullptr)
            live->journal = std::make_unique<io::Journal>(live->journal_path, live->terrain.terrain().header());
        io::Journal& journal = *live->journal;
        const auto found = std::ranges::find(journal.layers(), layer, &io::JournalLayer::name);
        const std::uint32_t id = found != journal.layers().end() ? found->id : journal.add_layer(layer);
        if (!kept.empty()) (void)journal.add_stamps(id, kept);
        journal.commit();
    });
}

FjellStatus fjell_live_update(FjellLive* live, const FjellView* views, size_t view_count, double now_s,
                              FjellLiveFrame* frame) {
    const Views seen(views, view_count);
    if (live == nullptr) return no_object;
    if (!seen.ok) return refused(struct_size);
    if (frame != nullptr && (frame->struct_size < sizeof frame->struct_size || frame->struct_size > sizeof *frame))
        return refused(struct_size);
    if (seen.all().empty() || seen.all().size() > live->terrain.options().cut.views)
        return {FJELL_OUT_OF_RANGE, "views (1 to the profile's budget.views)"};
    for (const View& view : seen.all())
        if (const Status status = validate(view); !status.ok()) return to_c(status);
    try {
        const io::LiveFrame& done = live->terrain.update(seen.all(), now_s);
        if (frame == nullptr) return {FJELL_OK, ""};
        const FjellLiveFrame all{.struct_size = frame->struct_size,
                                 .mesh = fjell_cut_mesh(to_c(live->terrain.cut())),
                                 .error_bound_px = done.cut.error_bound_px,
                                 .converged = done.converged,
                                 .settled = done.settled,
                                 .failed = done.stream.failed,
                                 .short_of = done.short_of.data(),
                                 .short_of_count = done.short_of.size(),
                                 .forgotten = done.forgotten};
        std::memcpy(frame, &all, static_cast<std::size_t>(all.struct_size));
        return {FJELL_OK, ""};
    } catch (const io::Failure&) { // of views and settings that were looked at, only the clock can be at fault
        return {FJELL_OUT_OF_RANGE, "now_s"};
    }
}
FjellStatus fjell_live_reports(const FjellLive* live, FjellCutReport* cut, FjellStreamReport* stream) {
    if (live == nullptr) return no_object;
    if (!fits(cut) || !fits(stream)) return refused(struct_size);
    write(live->terrain.frame().cut, cut);
    write(live->terrain.frame().stream, stream);
    return {FJELL_OK, ""};
}

FjellCutChanges fjell_live_take_changes(FjellLive* live) {
    return fjell_cut_take_changes(fjell_live_cut(live));
}
const FjellMapCommand* fjell_live_take_map_commands(FjellLive* live, size_t* count) {
    return elements(live == nullptr ? std::span<const MapCommand>() : live->terrain.take_map_commands(), count);
}
const FjellTileMap* fjell_live_tile_maps(FjellLive* live, uint8_t map, size_t* count) {
    const bool any = live != nullptr && map < map_kinds;
    return elements(any ? live->terrain.tile_maps(static_cast<MapKind>(map)) : std::span<const TileMap>(), count);
}

FjellTerrain fjell_live_terrain(const FjellLive* live) {
    return live == nullptr ? FjellTerrain{} : to_c(live->terrain.terrain());
}
FjellLiveCut fjell_live_cut(const FjellLive* live) {
    return live == nullptr ? FjellLiveCut{} : to_c(live->terrain.cut());
}
FjellEdits fjell_live_edits(const FjellLive* live) {
    return live == nullptr ? FjellEdits{} : to_c(live->terrain.edits());
}
FjellStream fjell_live_stream(const FjellLive* live) {
    return live == nullptr ? FjellStream{} : to_c(live->terrain.stream());
}
size_t fjell_live_memory_bytes(const FjellLive* live) {
    return live == nullptr ? 0 : live->terrain.memory_bytes();
}
void fjell_live_first_failure(const FjellLive* live, char* why, size_t why_bytes) {
    (void)attempt(why, why_bytes, [&] {
        if (live != nullptr) tell(live->terrain.first_failure().c_str(), why, why_bytes);
    });
}
