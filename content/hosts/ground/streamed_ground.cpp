#include "streamed_ground.h"

namespace ground {

namespace {

constexpr fjell::EditBudget changing{.blocks = 64, .stamps = 16, .areas = 16};
constexpr std::size_t most_changes = 64; // a tick
constexpr fjell::StreamBudget streaming{.page_requests = 16, .map_requests = 1, .map_bytes = 64 << 20};

} // namespace

std::string text_of(fjell::Status status) {
    return status.ok() ? "" : std::string(status.field) + ": " + fjell::message(status.code);
}

fjell::View focus(fjell::Vec3 place_m, double reach_m, double accuracy_m) {
    fjell::View view;
    view.eye_m = place_m;
    view.max_error_px = fjell::focal_length_px(view) * accuracy_m / reach_m; // so large accuracy_m is from reach_m away
    return view;
}

std::string StreamedGround::create(const game::PackOnDisk& file, std::uint32_t page_slots) {
    file_ = &file;
    const fjell::Pack& pack = file.pack();
    const fjell::TerrainBudget pages{.page_slots = page_slots};
    const auto allocate = [this](std::size_t bytes) {
        const std::span<std::byte> piece = memory_.allocate(bytes);
        bytes_ += piece.size();
        return piece;
    };
    fjell::Status s = fjell::create_terrain(pack, file.corners(), pages,
                                            allocate(fjell::terrain_bytes(pack.header, pages)), terrain_);
    if (!s.ok()) return text_of(s);
    s = fjell::create_edits(terrain_, changing, allocate(fjell::edits_bytes(pack.header, changing)), edits_);
    if (!s.ok()) return text_of(s);
    changes_.reserve(most_changes);
    // Without a cut: nothing is drawn.
    s = fjell::create_stream(pack, terrain_, {}, streaming, allocate(fjell::stream_bytes(pack, terrain_, streaming)),
                             stream_);
    return text_of(s);
}

StreamedGround::~StreamedGround() {
    (void)fjell::destroy_stream(stream_);
    (void)fjell::destroy_edits(edits_);
    (void)fjell::destroy_terrain(terrain_);
}

fjell::Status StreamedGround::update(std::span<const fjell::View> views, double now_s) {
    const fjell::StreamSettings settings{.texel_px = 100, .lookahead_s = 0, .now_s = now_s}; // maps: the least there is
    fjell::EditReport edited;
    fjell::Status s = fjell::update_edits(edits_, views, {}, edited);
    if (!s.ok()) return s;
    bool lost = false; // then the one rectangle is the whole terrain
    changes_.resize(most_changes);
    changes_.resize(fjell::take_ground_changes(edits_, seen_, changes_, lost));
    s = fjell::update_stream(stream_, views, {.max_error_px = 1}, settings, report_);
    for (const fjell::PageArrival& page : fjell::stream_page_arrivals(stream_)) {
        came_ += page.event == fjell::PageEvent::inserted;
        went_ += page.event == fjell::PageEvent::removed;
    }
    return s;
}

void StreamedGround::answer(int most) {
    fjell::StreamRequest request;
    for (; most > 0 && fjell::stream_next_request(stream_, request); --most) {
        read_.resize(request.bytes);
        if (file_->read(request.offset, read_))
            (void)fjell::stream_provide(stream_, request.ticket, read_);
        else
            (void)fjell::stream_fail(stream_, request.ticket);
    }
}

std::string Yardstick::create(const game::PackOnDisk& file) {
    const fjell::PackHeader& header = file.pack().header;
    const std::span<std::byte> whole = memory_.allocate(header.file_bytes);
    if (!file.read(0, whole.first(header.file_bytes))) return "the pack cannot be read; check the disk";
    fjell::Pack pack;
    if (fjell::Status s = fjell::open_pack(whole.first(header.file_bytes), pack); !s.ok()) return text_of(s);
    fjell::Status s = fjell::load_terrain(pack, memory_.allocate(fjell::terrain_bytes(header)), terrain_);
    if (s.ok())
        s = fjell::create_edits(terrain_, changing, memory_.allocate(fjell::edits_bytes(header, changing)), edits_);
    return text_of(s);
}

std::string Yardstick::stamp(const fjell::Stamp& stamp) {
    fjell::StampId id = 0;
    fjell::EditReport report;
    fjell::Status s = fjell::push_stamp(edits_, stamp, id);
    if (s.ok()) s = fjell::update_edits(edits_, {}, {}, report);
    return text_of(s.ok() ? fjell::stamp_state(edits_, id).status : s);
}

} // namespace ground
