#include <algorithm>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

#include <sys/resource.h>
#include <unistd.h>

#include <fmt/format.h>

#include "baker/bake/bake.h"
#include "baker/bake/recipe.h"
#include "baker/georeference/open_source.h"
#include "baker/synth/synth.h"
#include "editor/jobs/factories.h"
#include "editor/number_text.h"
#include "editor/strings.h"
#include "fjell/io/failure.h"
#include "io/file.h"

namespace fjell::editor {

namespace {

using io::Failure;

void set_word(std::optional<std::string>& word, const std::string& value, const char* key) {
    if (value.empty()) return;
    const std::vector<std::string>& known = baker::recipe_key(key).words;
    if (!known.empty() && std::ranges::find(known, value) == known.end())
        throw Failure(2, fmt::format(strings::refusals::bad_word, key, value, fmt::join(known, ", ")));
    word = value;
}

} // namespace

baker::Recipe bake_recipe(const BakePack& b) {
    if (b.inputs.empty() || b.inputs.front().empty()) throw Failure(2, strings::refusals::no_heights);
    baker::Recipe recipe;
    recipe.inputs = b.inputs;
    recipe.output = b.output;
    if (!b.texture.empty()) recipe.texture = {b.texture};
    if (!b.ramp.empty()) recipe.ramp = b.ramp;
    if (b.tile != 0) recipe.tile = std::to_string(b.tile);
    if (!(b.spacing_m >= 0)) throw Failure(2, fmt::format(strings::refusals::bad_spacing, b.spacing_m));
    if (b.spacing_m > 0) recipe.spacing = b.spacing_m;
    if (b.height_scale != 1) recipe.zscale = b.height_scale;
    if (b.height_offset_m != 0) recipe.zoffset = b.height_offset_m;
    set_word(recipe.order, b.order, "order");
    set_word(recipe.nodata, b.nodata, "nodata");
    if (!b.voids.empty()) baker::parse_voids(b.voids, recipe.voids);
    if (!b.crs.empty()) recipe.crs = b.crs;
    if (!b.rules.empty()) recipe.layers = b.rules;
    set_word(recipe.control, b.control, "control");
    set_word(recipe.horizons, b.horizons, "horizons");
    set_word(recipe.encoding, b.encoding, "encoding");
    if (!b.bbox.empty()) recipe.bbox = baker::parse_bbox(b.bbox);
    if (b.memory_mb < 128 || b.memory_mb > 1u << 24)
        throw Failure(2, fmt::format(strings::refusals::bad_memory, b.memory_mb, 1u << 24));
    return recipe;
}

std::unique_ptr<baker::HeightSource> bake_source(const baker::Recipe& recipe) {
    if (recipe.inputs.size() == 1 && recipe.inputs[0].ends_with(".json")) return baker::open_synth(recipe.inputs[0]);
    return baker::open_source(recipe.inputs, baker::read_options(recipe));
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
        const baker::BakeSummary s = baker::bake(*bake_source(recipe), options, output);
        control.publish([&](JobView& view) {
            view.output = output;
            view.result = fmt::format(strings::results::baked, output, s.columns, s.rows, s.tree.tiles_x,
                                      s.tree.tiles_y, s.tree.side(), byte_text(static_cast<double>(s.file_bytes)).text,
                                      s.seconds_total, s.resumed ? strings::results::baked_resumed : "");
            for (const std::string& line : baker::remarks(s)) view.result += "; " + line;
        });
    } catch (const Failure&) {
        if (!control.cancelled()) throw;
        std::error_code ignored;
        const std::string work = output + ".work";
        const bool stays = std::filesystem::exists(work, ignored);
        control.publish([&](JobView& view) {
            view.result =
                stays ? fmt::format(strings::results::bake_can_resume, work) : strings::results::no_files_remain;
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

} // namespace fjell::editor
