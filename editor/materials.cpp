#include "editor/materials.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "fjell/io/failure.h"
#include "fjell/io/pack_file.h"
#include "fjell/query.h"
#include "fjell/terrain.h"
#include "fjell/texture.h"
#include "io/file.h"

namespace fjell::editor {

namespace {

namespace fs = std::filesystem;

struct ContentFile {
    const char* name; // materials/rock.json, rules/alpine.json
    std::span<const char> text;
};
#include "materials.inc" // content_files[]

constexpr std::uint32_t small_mip_log2 = 6;

void write_content(const std::string& folder, std::string_view beginning) {
    for (const ContentFile& f : content_files) {
        if (!std::string_view(f.name).starts_with(beginning)) continue;
        const fs::path path = fs::path(folder) / f.name;
        std::error_code ignored; // what is wrong with the folder, the file says
        fs::create_directories(path.parent_path(), ignored);
        io::AtomicFile file(path.string());
        file.write(std::as_bytes(f.text));
        file.commit();
    }
}

} // namespace

std::string built_in_file(const std::string& cache_folder) {
    return cache_folder + "/ground.fjell-materials";
}

std::string built_in_recipes(const std::string& cache_folder) {
    return cache_folder + "/materials";
}

void write_built_in(const std::string& cache_folder) {
    if (cache_folder.empty()) throw io::Failure(3, "there is no folder for the materials; set XDG_CACHE_HOME or HOME");
    write_content(cache_folder, "materials/");
}

std::string rules_file(const std::string& cache_folder, const std::string& rules) {
    if (std::ranges::find(built_in_rules, rules) == std::end(built_in_rules)) return rules;
    write_content(cache_folder, "rules/" + rules);
    return cache_folder + "/rules/" + rules + ".json";
}

void GroundShares::follow(const session::Session& session, const session::GroundLayers* layers,
                          const gl::LayerSettings& settings, double x_m, double z_m) {
    const PackHeader& header = session.loaded.pack.header;
    if (hash_ != header.directory_hash) {
        forget();
        hash_ = header.directory_hash;
    }
    const bool splat = header.splat_log2 != 0 && settings.splat;
    if (layers == nullptr || (!splat && layers->rules.empty())) return shares_.clear();
    splat ? by_splat(session, x_m, z_m) : by_rules(session, *layers, x_m, z_m);
    std::ranges::sort(shares_, std::ranges::greater{}, &Share::share);
}

void GroundShares::by_splat(const session::Session& session, double x_m, double z_m) {
    const PackHeader& header = session.loaded.pack.header;
    const Terrain& terrain = session.terrain();
    const double cells = 1u << header.tile_log2, width_m = cells * header.spacing_m[0],
                 depth_m = cells * header.spacing_m[1];
    const auto column = static_cast<std::int32_t>(std::floor(x_m / width_m)),
               row = static_cast<std::int32_t>(std::floor(z_m / depth_m));
    const std::uint32_t tile = terrain.tile_at({column, row});
    if (tile != tile_) {
        tile_ = tile;
        side_ = 0;
        try {
            if (names_.empty()) {
                session.file->read_chunk({ChunkKind::layers, 0, 0}, raw_);
                names_ = io::layer_names({reinterpret_cast<const char*>(raw_.data()), raw_.size()});
            }
            const std::uint32_t log2 = std::min(header.splat_log2, small_mip_log2);
            if (tile != no_tile) {
                session.file->read_chunk({ChunkKind::splat, tile, header.splat_log2 - log2}, raw_);
                side_ = 1u << log2;
            }
        } catch (const io::Failure&) { // the flight says what cannot be read
        }
    }
    shares_.clear();
    if (side_ == 0) return;
    const auto place = [this](double share) {
        return static_cast<std::size_t>(std::clamp(std::round(share * (side_ - 1)), 0.0, side_ - 1.0));
    };
    const std::size_t at = place(z_m / depth_m - row) * side_ + place(x_m / width_m - column);
    for (std::size_t i = 0; i < splat_layers; ++i) {
        const auto weight = static_cast<std::uint8_t>(raw_[splat_texel_bytes * at + 2 * i]),
                   name = static_cast<std::uint8_t>(raw_[splat_texel_bytes * at + 2 * i + 1]);
        if (weight != 0 && name < names_.size()) shares_.push_back({names_[name], weight / 255.0});
    }
}

void GroundShares::by_rules(const session::Session& session, const session::GroundLayers& layers, double x_m,
                            double z_m) {
    const GroundHeight ground = ground_height(session.terrain(), x_m, z_m);
    double of_rule[gl::max_layer_rules] = {};
    gl::layer_shares(layers.rules, ground.height_m,
                     std::acos(std::clamp(ground.normal.y, -1.0, 1.0)) * 180 / std::numbers::pi, 0.5, 0.5,
                     {of_rule, layers.rules.size()});
    shares_.resize(layers.materials.records.size());
    for (std::size_t i = 0; i < shares_.size(); ++i) shares_[i] = {layers.materials.records[i].name, 0};
    for (std::size_t i = 0; i < layers.rules.size(); ++i) shares_[layers.rules[i].material].share += of_rule[i];
    std::erase_if(shares_, [](const Share& s) { return s.share < 0.005; });
}

} // namespace fjell::editor
