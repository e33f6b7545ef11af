// Jobs that write a file: a pack, a mesh, a picture.
#include "editor/jobs/work.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

#include <sys/resource.h>
#include <unistd.h>

#include <fmt/format.h>

#include "baker/bake/bake.h"
#include "baker/bake/inputs.h"
#include "baker/bake/recipe.h"
#include "baker/georeference/crs_label.h"
#include "baker/materials/encode.h"
#include "editor/number_text.h"
#include "fjell/gl/context.h"
#include "fjell/gl/image.h"
#include "fjell/gl/target.h"
#include "fjell/gltf/snapshot.h"
#include "fjell/io/failure.h"
#include "io/file.h"
#include "session/pictures.h"
#include "session/session.h"
#include "session/snapshots.h"

namespace fjell::editor {

namespace {

using io::Failure;

void set_word(std::optional<std::string>& word, const std::string& value, const char* key) {
    if (value.empty()) return;
    const std::vector<std::string>& known = baker::recipe_key(key).words;
    if (!known.empty() && std::ranges::find(known, value) == known.end())
        throw Failure(2, fmt::format("{}={}: must be one of {}", key, value, fmt::join(known, ", ")));
    word = value;
}

} // namespace

baker::Recipe bake_recipe(const BakePack& b) {
    if (b.inputs.empty() || b.inputs.front().empty()) throw Failure(2, "choose a file of heights to bake");
    baker::Recipe recipe;
    recipe.inputs = b.inputs;
    recipe.output = b.output;
    if (!b.texture.empty()) recipe.texture = {b.texture};
    if (!b.ramp.empty()) recipe.ramp = b.ramp;
    if (b.tile != 0) recipe.tile = std::to_string(b.tile);
    if (!(b.spacing_m >= 0)) throw Failure(2, fmt::format("spacing={}: must be 0 or more (metres)", b.spacing_m));
    if (b.spacing_m > 0) recipe.spacing = b.spacing_m;
    if (b.height_scale != 0) recipe.zscale = b.height_scale;
    if (b.height_offset_m != 0) recipe.zoffset = b.height_offset_m;
    set_word(recipe.order, b.order, "order");
    set_word(recipe.nodata, b.nodata, "nodata");
    if (!b.voids.empty()) baker::parse_voids(b.voids, recipe.voids);
    if (!b.crs.empty()) recipe.crs = b.crs;
    if (!b.rules.empty()) recipe.layers = b.rules;
    set_word(recipe.splat, b.splat, "splat");
    set_word(recipe.horizons, b.horizons, "horizons");
    set_word(recipe.encoding, b.encoding, "encoding");
    if (!b.bbox.empty()) recipe.bbox = baker::parse_bbox(b.bbox);
    set_word(recipe.band, b.band, "band");
    set_word(recipe.size, b.size, "size");
    set_word(recipe.vertical_unit, b.vertical_unit, "vertical-unit");
    if (!b.texture.empty()) set_word(recipe.texture_bands, b.texture_bands, "texture-bands");
    if (b.memory_mb < 128 || b.memory_mb > 1u << 24)
        throw Failure(2, fmt::format("memory_mb={}: must be 128 to {}", b.memory_mb, 1u << 24));
    return recipe;
}

namespace {

// A bake takes every core for seconds or minutes, and so would starve the frames of who flies on. Its threads inherit
// this; where it may not be had, nothing is lost.
void yield_to_frames() {
    (void)setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 15);
}

void run(const baker::Recipe& recipe, baker::BakeOptions options, JobControl& control) {
    const std::string& output = *recipe.output;
    yield_to_frames();
    control.progress("open", 0, 1);
    io::refuse_overwriting(baker::places_written(output), baker::files_read(recipe));
    options.progress = [&](const char* stage, std::uint64_t done, std::uint64_t total) {
        io::check_interrupt();
        // The baker knows this one: it keeps what is done where a later bake can go on from it.
        if (control.cancelled()) throw Failure(130, "cancelled");
        control.progress(stage, done, total);
    };
    baker::limit_gdal_cache(options.memory_bytes / 16);
    try {
        const baker::BakeSummary s = baker::bake(*baker::open_inputs(recipe), options, output);
        control.publish([&](JobView& view) {
            view.output = output;
            view.result = fmt::format("{}: {} x {} samples, {} x {} tiles of {} cells, {} in {:.1f} s{}", output,
                                      s.columns, s.rows, s.tree.tiles_x, s.tree.tiles_y, s.tree.side(),
                                      byte_text(static_cast<double>(s.file_bytes)).text, s.seconds_total,
                                      s.resumed ? ", resumed from an earlier bake" : "");
            const std::string crs = baker::crs_text(baker::crs_label(s.crs_wkt));
            view.result += crs.empty() ? "; no CRS" : "; " + crs;
            for (const std::string& line : baker::remarks(s)) view.result += "; " + line;
        });
    } catch (const Failure&) {
        if (!control.cancelled()) throw;
        std::error_code ignored;
        const std::string work = output + ".work";
        const bool stays = std::filesystem::exists(work, ignored);
        control.publish([&](JobView& view) {
            view.result = stays ? fmt::format("{} remains: the same bake resumes from it; or delete it", work)
                                : "no files remain";
        });
        throw Cancelled{};
    }
}

} // namespace

std::string pack_beside(const std::string& input) {
    return input.empty() ? "" : std::filesystem::path(input).replace_extension(".fjell").string();
}

Jobs::Body bake_job(BakePack bake) {
    if (bake.output.empty() && !bake.inputs.empty()) bake.output = pack_beside(bake.inputs.front());
    const baker::Recipe recipe = bake_recipe(bake);
    baker::BakeOptions options = baker::bake_options(recipe);
    if (bake.checkpoint_s >= 0) options.checkpoint_s = bake.checkpoint_s;
    options.memory_bytes = std::uint64_t{bake.memory_mb} << 20;
    std::vector<std::string> inputs = recipe.inputs;
    inputs.push_back(bake.texture);
    inputs.push_back(bake.ramp);
    inputs.push_back(bake.rules);
    io::refuse_overwriting({bake.output}, inputs);
    return [recipe, options = std::move(options)](JobControl& control) { run(recipe, options, control); };
}

Jobs::Body materials_job(const std::string& recipes, const std::string& output) {
    return [=](JobControl& control) {
        constexpr std::uint32_t side = 256; // a quarter of the time, and of the memory
        yield_to_frames();
        control.progress("textures", 0, 1);
        baker::bake_materials(recipes, side, 0, output, "");
        control.publish([&](JobView& view) { view.output = output; });
    };
}

// --- A mesh as glTF: the frame's, taken when the job was made, as a streamed terrain changes under its frame; or one
// that is refined over a terrain of the job's own.

namespace {

gltf::SnapshotOptions snapshot_options(const ExportPlan& plan, JobControl& control) {
    gltf::SnapshotOptions options;
    options.write = !plan.path.empty();
    options.texel_m = plan.texel_m;
    options.quantised = plan.quantised, options.meshopt = plan.meshopt;
    options.colours = plan.jpeg ? gltf::SnapshotImage::jpeg : gltf::SnapshotImage::png;
    options.progress = [&control, write = options.write](std::uint64_t done, std::uint64_t total) {
        if (control.cancelled()) return false;
        control.progress(write ? "tiles" : "measure", done, total);
        return true;
    };
    return options;
}

gltf::SnapshotCounts write(const ExportPlan& plan, const gltf::Snapshot& snapshot, JobControl& control) {
    control.goes_from(plan.frame.empty() ? 0.3 : 0.02, 1);
    return session::write_snapshot(*plan.pack, snapshot, plan.path, snapshot_options(plan, control),
                                   {plan.layers, plan.profile.layers});
}

// A session that is as the frame's; of a streamed one with as much as the view wants and the page slots hold.
gltf::SnapshotCounts write_refined(const ExportPlan& plan, JobControl& control) {
    session::FlightOptions options = options_of(plan.pack, plan.profile);
    options.streaming = plan.streamed ? session::Streaming::on : session::Streaming::off;
    options.profile.stream.fade_s = options.profile.stream.lookahead_s = 0; // time stands still
    const bool own = plan.error_px > 0;
    if (own) {
        options.profile.refine.max_error_px = plan.error_px;
        options.profile.refine.corner_safe = false;
    }
    session::Session session;
    session::open_session(options, session);
    control.check();
    control.goes_from(0.02, 0.2);
    if (!own || session.streamed || session.edits)
        (void)session::update_until_there(
            session, plan.view, options.profile, 0, [&](const session::FrameEntry& entry) {
                const std::uint64_t wanted = entry.stream.pages_wanted, left = entry.stream.pages_left;
                control.progress("stream", wanted > left ? wanted - left : 0, wanted);
            });
    control.goes_from(0.2, 0.3);
    control.progress("refine", 0, 1);
    return write(
        plan, own ? gltf::take_refined(session.terrain(), plan.view, plan.error_px) : session::take_converged(session),
        control);
}

void run(const ExportPlan& plan, JobControl& control) {
    control.goes_from(0, 0.02);
    control.progress("open", 0, 1);
    const gltf::SnapshotCounts r = plan.frame.empty() ? write_refined(plan, control) : write(plan, plan.frame, control);
    control.publish([&](JobView& view) {
        view.share = 1;
        view.output = plan.path;
        view.preview = {r.error_bound_px, r.vertices, r.triangles, r.file_bytes};
        view.result = fmt::format("{}{} vertices, {} triangles, {} within {:.3g} px{}",
                                  plan.path.empty() ? "the export has " : plan.path + ": ",
                                  grouped(static_cast<double>(r.vertices)), grouped(static_cast<double>(r.triangles)),
                                  byte_text(static_cast<double>(r.file_bytes)).text, r.error_bound_px,
                                  r.converged ? "" : ", which is not what was asked for");
    });
}

} // namespace

Jobs::Body export_job(ExportPlan plan) {
    if (plan.error_px != 0 &&
        !(plan.error_px >= ranges::least_threshold_px && plan.error_px <= ranges::most_threshold_px))
        throw io::Failure(2, fmt::format("a threshold of {} px: must be {} to {}", plan.error_px,
                                         ranges::least_threshold_px, ranges::most_threshold_px));
    if (!(plan.texel_m >= 0 && plan.texel_m <= 1e6))
        throw io::Failure(2, fmt::format("a texel of {} m: must be 0 to 1,000,000", plan.texel_m));
    io::refuse_overwriting({plan.path}, {plan.pack->path()});
    return [plan = std::move(plan)](JobControl& control) { run(plan, control); };
}

// --- A picture of any size beside the frame. It shows the mesh that its view settles on, whatever a frame may do:
// budgets of items and time are for frames that must be in time.

namespace {

void draw_picture_of(const PicturePlan& plan, JobControl& control) {
    control.progress("open", 0, 1);
    // In the order of destruction, last first: GL objects need their context, and all the terrain.
    const session::FlightOptions options = options_of(plan.pack, plan.profile, plan.layers);
    session::Session session;
    session::open_session(options, session);
    const auto context = gl::Headless::create();
    const auto target = session::make_target(plan.profile.width_px, plan.profile.height_px, plan.profile);
    const auto renderer = session::make_renderer(options, session);
    const View view = session::view_of(plan.pose, session.terrain(), plan.profile);
    (void)session::update_until_there(session, view, plan.profile, 0, [&](const session::FrameEntry& poll) {
        control.check();
        session::upload_mesh(*renderer, session, poll);
    });
    renderer->draw_uploaded(session.mesh(), view, session::draw_options(plan.mode, plan.profile, 0), *target);
    gl::Image image;
    target->read_colour(image);
    gl::write_png(image, plan.path);
    control.publish([&](JobView& shown) {
        shown.output = plan.path;
        shown.result = fmt::format("{}: {} x {} pixels", plan.path, plan.profile.width_px, plan.profile.height_px);
    });
}

} // namespace

Jobs::Body picture_job(PicturePlan plan) {
    if (plan.path.empty()) throw io::Failure(2, "give the picture a file name");
    io::refuse_overwriting({plan.path}, {plan.pack->path()});
    // What no frame waits for may take its time.
    plan.profile.cut.max_work = unlimited_work;
    plan.profile.cut.max_time_us = 0;
    plan.profile.stream.fade_s = plan.profile.stream.lookahead_s = 0;
    return [plan = std::move(plan)](JobControl& control) { draw_picture_of(plan, control); };
}

} // namespace fjell::editor
