#include "session/snapshots.h"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "fjell/gl/ground_colour.h"
#include "fjell/io/failure.h"

namespace fjell::session {

using io::Failure;

gltf::Snapshot take_frame(const Session& session) {
    return session.method->take_frame();
}

gltf::Snapshot take_converged(const Session& session) {
    return session.method->take_converged();
}

namespace {

constexpr std::uint32_t largest_painted_px = 4096;

// The splat map of a tile at the mip whose texels are about as far apart as those that are painted.
struct SplatMip {
    std::uint32_t level = 0, side = 0;
};
SplatMip splat_mip(const PackHeader& h, std::uint32_t painted_side) {
    const std::uint32_t mips = mip_count(h.splat_log2);
    if (mips == 0) return {};
    std::uint32_t level = 0;
    while (level + 1 < mips && 1u << (h.splat_log2 - level) > painted_side) ++level;
    return {level, 1u << (h.splat_log2 - level)};
}

// Paints tile by tile; all texels are as far apart as the first tile's.
class Painter {
public:
    Painter(const io::PackFile& file, const GroundPaint& paint)
        : file_(file), layers_(paint.layers), settings_(paint.settings), names_(names_of_layers(file)),
          by_map_(!names_.empty() && settings_.splat) {
        if (!by_map_ && layers_->rules.empty())
            throw Failure(2, file.path() + ": has no splat map that says where materials lie; give rules too, or "
                                           "export without layers (layers.on = false)");
    }

    void operator()(const gltf::TileTexels& t) {
        if (!set_) {
            colour_.set(layers_->materials, layers_->rules, names_, settings_, std::max(t.step_x_m, t.step_z_m));
            set_ = true;
        }
        gl::GroundTexels texels{t.side, t.x_m, t.z_m, t.step_x_m, t.step_z_m};
        if (by_map_) {
            const SplatMip mip = splat_mip(file_.pack().header, t.side);
            file_.read_chunk({ChunkKind::splat, t.tile, mip.level}, splat_);
            texels.splat = splat_;
            texels.splat_side = mip.side;
        }
        texels.height_m = t.height_m;
        texels.slope_deg = t.slope_deg;
        texels.rgb = t.rgb;
        if (!colour_.paint(texels)) throw Failure(1, file_.path() + ": splat map: is of another size");
    }

private:
    const io::PackFile& file_;
    std::shared_ptr<const GroundLayers> layers_;
    gl::LayerSettings settings_;
    std::vector<std::string> names_;
    bool by_map_, set_ = false;
    gl::GroundColour colour_;
    std::vector<std::byte> splat_;
};

} // namespace

std::vector<std::string> names_of_layers(const io::PackFile& file) {
    if (file.pack().header.layer_bytes == 0) return {};
    std::vector<std::byte> text;
    file.read_chunk({ChunkKind::layers, 0, 0}, text);
    return io::layer_names({reinterpret_cast<const char*>(text.data()), text.size()});
}

gltf::SnapshotCounts write_snapshot(const io::PackFile& file, const gltf::Snapshot& snapshot, const std::string& path,
                                    gltf::SnapshotOptions options, const GroundPaint& paint) {
    if (paint.layers && paint.settings.on) {
        options.paint = Painter(file, paint);
        // What is painted has no finest mip, so the size that is asked for counts.
        if (options.texel_m > 0) options.max_texture_px = std::max(options.max_texture_px, largest_painted_px);
    }
    return gltf::write_snapshot(file, snapshot, path, options);
}

} // namespace fjell::session
