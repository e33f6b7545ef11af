// The keys of [layers]: gl::LayerSettings, and the memory of their textures.
#include "flight/profile_fields.h"

namespace fjell::flight {

namespace {

using Layers = gl::LayerSettings;

constexpr ProfileKey layer_keys[] = {
    {.table = "layers",
     .name = "on",
     .label = "Detail layers",
     .kind = KeyKind::flag,
     .about =
         "Materials on near ground, of fjell-fly --materials and --layers: true or false. Without such files there "
         "are none. Some 10 to 20 texture reads a pixel, only where the ground is near.",
     .get = At<&Profile::layers, &Layers::on>::get,
     .set = At<&Profile::layers, &Layers::on>::set},
    {.table = "layers",
     .name = "control",
     .label = "Control maps",
     .kind = KeyKind::flag,
     .about = "Materials where a pack's control maps say, of fjell-bake --layers: true or false. They take room among "
              "the maps on the GPU, and 4 to 8 texture reads a pixel. Without them rules say: fjell-fly --layers.",
     .rebuild = Rebuild::session,
     .get = At<&Profile::layers, &Layers::control>::get,
     .set = At<&Profile::layers, &Layers::control>::set},
    {.table = "layers",
     .name = "distance_m",
     .label = "Drawn up to",
     .unit = "m",
     .least = gl::min_layer_distance_m,
     .most = gl::max_layer_distance_m,
     .logarithmic = true,
     .about = "From how far on the ground is as its map has it. Metres, 1 to 100000; from 0.4 of it on materials fade. "
              "Pixels beyond it cost next to nothing on a GPU; in software a far view takes 1.2 times as long.",
     .get = At<&Profile::layers, &Layers::distance_m>::get,
     .set = At<&Profile::layers, &Layers::distance_m>::set},
    {.table = "layers",
     .name = "tint",
     .label = "Tint",
     .about = "How far a material takes on the colour of the map under it. 0 to 1: at 0 it has its own, at 1 near and "
              "far ground are of one colour.",
     .get = At<&Profile::layers, &Layers::tint>::get,
     .set = At<&Profile::layers, &Layers::tint>::set},
    {.table = "layers",
     .name = "relief",
     .label = "Relief",
     .most = gl::max_layer_relief,
     .about = "How strongly a material's bumps catch the light. 0 to 4; 1 is their true relief.",
     .get = At<&Profile::layers, &Layers::relief>::get,
     .set = At<&Profile::layers, &Layers::relief>::set},
    {.table = "layers",
     .name = "material_mb",
     .label = "Material textures",
     .kind = KeyKind::whole,
     .unit = "MB",
     .least = 1,
     .most = max_material_mb,
     .logarithmic = true,
     .about = "GPU memory for the textures of materials. MB, 1 to 65536: their finest mips are left out until they "
              "fit. Ten materials of 512 texels a side take 7 MB.",
     .rebuild = Rebuild::method,
     .get = At<&Profile::material_bytes, nullptr, 20>::get,
     .set = At<&Profile::material_bytes, nullptr, 20>::set},
};

} // namespace

std::span<const ProfileKey> layers_keys() {
    return layer_keys;
}

} // namespace fjell::flight
