// From heights to meshes and packs, and what packs say of themselves. Reports are JSON, as the command line writes
// them.
#include "baking.h"

#include <array>
#include <memory>
#include <optional>
#include <string>

#include <pybind11/stl.h>

#include "arrays.h"
#include "baker/bake/bake.h"
#include "baker/bake/inputs.h"
#include "baker/bake/recipe.h"
#include "baker/cli/reports.h"
#include "baker/cli/summary.h"
#include "baker/outlets/height_mesh.h"
#include "baker/read/pack_source.h"
#include "baker/synth/write_dem.h"
#include "fjell/io/failure.h"
#include "fjell/io/pack_file.h"
#include "io/file.h"
#include "io/set_file.h"
#include "watched.h"

namespace fjell::python {

namespace py = pybind11;
using namespace fjell::baker;

namespace {

NoData nodata_of(const std::string& holes) {
    if (holes == "keep") return NoData::hole;
    if (holes == "fill") return NoData::fill;
    if (holes == "refuse") return NoData::refuse;
    throw py::value_error("holes: is '" + holes + "'; give 'keep', 'fill' or 'refuse'");
}

py::tuple mesh(const py::array& heights, const py::object& mask, const std::array<double, 2>& spacing, double max_error,
               const std::string& holes, const std::string& up, int threads) {
    const HeightArray array = height_array(heights, mask);
    if (up != "y" && up != "z") throw py::value_error("up: is '" + up + "'; give 'y' or 'z'");
    HeightMeshOptions options{{spacing[0], spacing[1]}, max_error, nodata_of(holes)};
    options.z_up = up == "z";
    options.threads = threads;
    HeightMesh made = watched([&] { return mesh_heights(array, options); });
    const auto vertices = static_cast<py::ssize_t>(made.vertices.size()),
               triangles = static_cast<py::ssize_t>(made.triangles.size());
    return py::make_tuple(array_of<float>(std::move(made.vertices), {vertices, 3}),
                          array_of<std::uint32_t>(std::move(made.triangles), {triangles, 3}), made.true_error_m);
}

// An array to be baked or compared with, where it is not files.
struct Given {
    std::optional<HeightArray> array;
    std::array<double, 2> spacing{1, 1}, origin{0, 0};

    // Options of reading that an array has no use for are refused.
    [[nodiscard]] std::unique_ptr<HeightSource> open(const Recipe& recipe) const {
        for (const char* const name : {"spacing", "band", "bbox", "encoding", "size", "vertical-unit"})
            std::visit(
                [&](const auto member) {
                    if (recipe.*member != std::decay_t<decltype(recipe.*member)>{})
                        throw io::Failure(2, std::string(name) + ": is for files; do it to the array");
                },
                recipe_key(name).member);
        ArrayPlace place{{spacing[0], spacing[1]}, {origin[0], origin[1]}, recipe.crs.value_or("")};
        Recipe reading = recipe;
        reading.crs.reset();
        return edited_source(array_source(*array, place, read_options(reading)), recipe);
    }
};

Given given(const py::object& heights, const py::object& mask, const std::array<double, 2>& spacing,
            const std::array<double, 2>& origin) {
    Given given{{}, spacing, origin};
    if (!heights.is_none()) given.array = height_array(heights.cast<py::array>(), mask);
    return given;
}

std::string bake_pack(const py::object& heights, const py::object& mask, const std::array<double, 2>& spacing,
                      const std::array<double, 2>& origin, const std::string& recipe_json, int threads,
                      std::uint64_t memory_mb, const py::object& progress) {
    Recipe recipe = parse_recipe(recipe_json, "options");
    const Given from = given(heights, mask, spacing, origin);
    std::string said;
    run_watched(
        [&](const Progress& report) {
            io::refuse_overwriting(places_written(*recipe.output), files_read(recipe));
            const std::unique_ptr<HeightSource> source = from.array ? from.open(recipe) : open_inputs(recipe);
            BakeOptions options = bake_options(recipe);
            options.threads = threads;
            options.memory_bytes = memory_mb << 20;
            options.progress = report;
            said = summary_json(bake(*source, options, *recipe.output)).dump();
        },
        progress);
    return said;
}

std::string verify_pack(const std::string& pack, const py::object& heights, const py::object& mask,
                        const std::array<double, 2>& spacing, const std::string& recipe_json) {
    const Recipe recipe = parse_recipe(recipe_json, "options");
    const Given from = given(heights, mask, spacing, {0, 0});
    return watched([&] {
        const std::unique_ptr<HeightSource> source = from.array ? from.open(recipe) : nullptr;
        return check_json(check_pack(pack, recipe, source.get())).dump();
    });
}

std::string info(const std::string& pack) {
    return watched([&] { return info_json(io::PackFile(pack)).dump(); });
}

void heights(const std::string& pack, const std::string& out) {
    run_watched([&](const Progress& report) {
        io::refuse_overwriting(places_written(out), io::files_of_pack(pack));
        write_dem(PackSource(pack), out, DemForm::plain, 0, report);
    });
}

py::list option_names() {
    py::list names;
    for (const RecipeKey& key : recipe_keys()) names.append(py::make_tuple(key.name, key.about, key.words));
    return names;
}

} // namespace

void add_baking(py::module_& module) {
    module.def("mesh", &mesh);
    module.def("bake", &bake_pack);
    module.def("verify", &verify_pack);
    module.def("info", &info);
    module.def("heights", &heights);
    module.def("option_names", &option_names);
}

} // namespace fjell::python
