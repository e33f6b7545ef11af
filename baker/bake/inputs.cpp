#include "baker/bake/inputs.h"

#include <fmt/format.h>

#include "baker/georeference/open_source.h"
#include "baker/read/coarse_source.h"
#include "baker/read/edited_source.h"
#include "baker/read/pack_source.h"
#include "baker/synth/synth.h"

namespace fjell::baker {

namespace {

std::unique_ptr<HeightSource> open_unedited(const Recipe& recipe) {
    if (recipe.inputs.size() == 1 && recipe.inputs[0].ends_with(".json")) return open_synth(recipe.inputs[0]);
    if (!is_pack(recipe)) return open_source(recipe.inputs, read_options(recipe));
    if (reading_part(recipe) != Recipe{})
        throw Failure(2, fmt::format("{}: is a pack, whose heights are in metres on a grid already; leave out --bbox, "
                                     "--nodata and what else says how files are read, or give the files",
                                     recipe.inputs[0]));
    return std::make_unique<PackSource>(recipe.inputs[0]);
}

} // namespace

std::unique_ptr<HeightSource> open_inputs(const Recipe& recipe) {
    return edited_source(open_unedited(recipe), recipe);
}

std::unique_ptr<HeightSource> edited_source(std::unique_ptr<HeightSource> source, const Recipe& recipe) {
    if (recipe.coarse_detail && !recipe.coarse)
        throw Failure(2, "--coarse-detail-m is of polygons without detail_m; give their file with --coarse");
    if (recipe.edits) source = edited_source(std::move(source), *recipe.edits);
    if (recipe.coarse) source = coarse_source(std::move(source), *recipe.coarse, recipe.coarse_detail);
    return source;
}

} // namespace fjell::baker
