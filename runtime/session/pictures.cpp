#include "session/pictures.h"

#include <algorithm>

#include <fmt/format.h>

#include "fjell/gl/context.h"
#include "fjell/gl/image.h"
#include "fjell/io/failure.h"
#include "session/snapshots.h"

namespace fjell::session {

using io::Failure;

struct Pictures::State { // in the order of destruction, last first
    std::unique_ptr<gl::Headless> context;
    std::unique_ptr<gl::Target> target;
    std::unique_ptr<gl::Renderer> renderer;
    PictureMode mode = PictureMode::shaded;
    Profile profile;
    std::string folder;
    gl::Image image;
};

gl::DrawOptions draw_options(PictureMode mode, const Profile& profile, double time_s) {
    gl::DrawOptions draw;
    draw.light = profile.light;
    draw.layers = profile.layers;
    draw.time_s = time_s;
    draw.wireframe = mode == PictureMode::wire;
    switch (mode) {
    case PictureMode::shaded:
    case PictureMode::wire: draw.mode = gl::Mode::shaded; break;
    case PictureMode::levels: draw.mode = gl::Mode::levels; break;
    case PictureMode::tiles: draw.mode = gl::Mode::tiles; break;
    case PictureMode::mips: draw.mode = gl::Mode::mips; break;
    case PictureMode::residency: draw.mode = gl::Mode::residency; break;
    case PictureMode::distance: draw.mode = gl::Mode::distance; break;
    }
    return draw;
}

std::unique_ptr<gl::Target> make_target(std::uint32_t width, std::uint32_t height, const Profile& profile) {
    return gl::Target::create({width, height, std::min(profile.samples, gl::max_target_samples())});
}

namespace {

void set_layers(gl::Renderer& renderer, const GroundLayers& layers, const Session& session) {
    const std::vector<std::string> names = names_of_layers(*session.file);
    if (names.empty() && layers.rules.empty())
        throw Failure(1, session.loaded.path +
                             ": has no splat map that says where materials lie; give rules too, "
                             "--layers content/materials/rules/alpine.json, or bake it with --layers");
    renderer.set_layers(layers.materials, layers.rules, names);
}

} // namespace

std::unique_ptr<gl::Renderer> make_renderer(const FlightOptions& options, const Session& session) {
    gl::RendererOptions slots;
    session.method->make_room(options.profile, session.streamed != nullptr, slots);
    if (session.streamed) {
        slots.colour = stream_map_layers(session.streamed->stream(), MapKind::colour);
        slots.normal = stream_map_layers(session.streamed->stream(), MapKind::normal);
        slots.horizon = stream_map_layers(session.streamed->stream(), MapKind::horizon);
        slots.splat = stream_map_layers(session.streamed->stream(), MapKind::splat);
    }
    slots.horizons = options.profile.light.shadows;
    slots.splat_maps = options.layers && options.profile.layers.splat;
    slots.light = options.profile.light;
    slots.material_bytes = options.profile.material_bytes;
    auto renderer = gl::Renderer::create(session.terrain(), session.loaded.pack, slots);
    if (options.layers) set_layers(*renderer, *options.layers, session);
    return renderer;
}

void upload_mesh(gl::Renderer& renderer, const Session& session, const FrameEntry& entry) {
    if (entry.rebuilt) renderer.invalidate();
    if (session.streamed) {
        const Stream stream = session.streamed->stream();
        renderer.upload(stream_map_commands(stream));
        renderer.show_maps(stream_tile_maps(stream, MapKind::colour), stream_tile_maps(stream, MapKind::normal),
                           stream_tile_maps(stream, MapKind::horizon), stream_tile_maps(stream, MapKind::splat));
    }
    if (session.edits) renderer.show_ground();
    session.method->upload(renderer);
}

Pictures::Pictures(const FlightOptions& options, const Session& session) : state_(std::make_unique<State>()) {
    state_->context = gl::Headless::create();
    state_->target = make_target(options.profile.width_px, options.profile.height_px, options.profile);
    try {
        state_->renderer = make_renderer(options, session);
    } catch (const Failure&) {
        if (!session.streamed)
            (void)io::check_all_chunks(session.loaded.pack,
                                       session.loaded.path); // a damaged pack is not the machine's fault
        throw;
    }
    state_->mode = options.mode;
    state_->profile = options.profile;
    state_->folder = options.render_folder;
}

bool is_picture_name(std::string_view name) {
    constexpr std::string_view begin = "frame_", end = ".png";
    if (name.size() < begin.size() + 5 + end.size() || !name.starts_with(begin) || !name.ends_with(end)) return false;
    name = name.substr(begin.size(), name.size() - begin.size() - end.size());
    return std::ranges::all_of(name, [](char c) { return c >= '0' && c <= '9'; });
}

Pictures::~Pictures() = default;

void Pictures::follow(const Session& session, const FrameEntry& entry) {
    upload_mesh(*state_->renderer, session, entry);
}

void Pictures::write(const Session& session, const View& view, std::size_t frame, double time_s) {
    while (session.edits && state_->renderer->stats().ground_waiting != 0) // a picture may take its time
        state_->renderer->show_ground();
    state_->renderer->draw_uploaded(session.mesh(), view, draw_options(state_->mode, state_->profile, time_s),
                                    *state_->target);
    state_->target->read_colour(state_->image);
    gl::write_png(state_->image, fmt::format("{}/frame_{:05}.png", state_->folder, frame));
}

} // namespace fjell::session
