#include "editor/files/sample.h"

#include <filesystem>
#include <iterator>
#include <span>

#include "fjell/io/failure.h"
#include "io/file.h"

namespace fjell::editor {

namespace {

constexpr char landscape[] = {
#include "mountains-small.inc"
};

} // namespace

std::string_view sample_landscape() {
    return {landscape, std::size(landscape)};
}

std::string sample_pack(const std::string& cache_folder) {
    return cache_folder + "/sample.fjell";
}

BakePack bake_sample(const std::string& cache_folder) {
    if (cache_folder.empty()) throw io::Failure(3, "there is no folder for the sample; set XDG_CACHE_HOME or HOME");
    std::error_code ignored; // what is wrong with the folder, the file says
    std::filesystem::create_directories(cache_folder, ignored);
    BakePack bake;
    bake.inputs = {cache_folder + "/sample.json"};
    bake.output = sample_pack(cache_folder);
    io::AtomicFile file(bake.inputs[0]);
    file.write(std::as_bytes(std::span(sample_landscape())));
    file.commit();
    return bake;
}

} // namespace fjell::editor
