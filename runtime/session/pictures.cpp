#include "session/pictures.h"

#include <algorithm>

#include <fmt/format.h>

#include "fjell/gl/context.h"
#include "fjell/gl/image.h"
#include "fjell/io/failure.h"
#include "session/snapshots.h"

namespace fjell::session {

using io::Failure;

void require_graphics(bool made, const std::string& error) {
    if (!made) throw Failure(3, error);
}

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

std::unique_ptr<gl::Target> make_target(std::uint32_t width, std::uint32_t height, const Profile& profile,
                                        std::string& error) {
    return gl::Target::create({width, height, std::min(profile.samples, gl::max_target_samples())}, error);
}

namespace {

void set_layers(gl::Renderer& renderer, const GroundLayers& layers, const Session& session) {
    const std::vector<std::string> names = names_of_layers(*session.file);
    if (names.empty() && layers.rules.empty())
        throw Failure(1, session.loaded.path +
                             ": has no splat map that says where materials lie; give rules too, "
                             "--layers content/materials/rules/alpine.json, or bake it with --layers");
    if (const std::string error = renderer.set_layers(layers.materials, layers.rules, names); !error.empty())
        throw Failure(1, error);
}

} // namespace

std::unique_ptr<gl::Renderer> make_renderer(const FlightOptions& options, const Session& session, std::string& error) {
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
    auto renderer = gl::Renderer::create(session.terrain(), session.loaded.pack, slots, error);
    if (renderer && options.layers) set_layers(*renderer, *options.layers, session);
    return error.empty() ? std::move(renderer) : nullptr;
}

std::string upload_mesh(gl::Renderer& renderer, const Session& session, const FrameEntry& entry) {
    if (entry.rebuilt) renderer.invalidate();
    if (session.streamed) {
        const Stream stream = session.streamed->stream();
        std::string error = renderer.upload(stream_map_commands(stream));
        if (error.empty())
            error = renderer.show_maps(
                stream_tile_maps(stream, MapKind::colour), stream_tile_maps(stream, MapKind::normal),
                stream_tile_maps(stream, MapKind::horizon), stream_tile_maps(stream, MapKind::splat));
        if (!error.empty()) return error;
    }
    return session.method->upload(renderer);
}

Pictures::Pictures(const FlightOptions& options, const Session& session) : state_(std::make_unique<State>()) {
    std::string error;
    state_->context = gl::Headless::create({}, error);
    require_graphics(state_->context != nullptr, error);
    state_->target = make_target(options.profile.width_px, options.profile.height_px, options.profile, error);
    require_graphics(state_->target != nullptr, error);
    state_->renderer = make_renderer(options, session, error);
    if (!state_->renderer && !session.streamed)
        (void)io::check_all_chunks(session.loaded.pack,
                                   session.loaded.path); // a damaged pack is not the machine's fault
    require_graphics(state_->renderer != nullptr, error);
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
    const std::string error = upload_mesh(*state_->renderer, session, entry);
    require_graphics(error.empty(), error);
}

void Pictures::write(const Session& session, const View& view, std::size_t frame, double time_s) {
    std::string error = state_->renderer->draw_uploaded(
        session.mesh(), view, draw_options(state_->mode, state_->profile, time_s), *state_->target);
    require_graphics(error.empty(), error);
    state_->target->read_colour(state_->image);
    error = gl::write_png(state_->image, fmt::format("{}/frame_{:05}.png", state_->folder, frame));
    require_graphics(error.empty(), error);
}

} // namespace fjell::session
