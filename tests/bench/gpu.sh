#!/usr/bin/env bash
# What a GPU takes for our pictures: bakes three scenes of the gallery and the benchmarks' mountains, flies them headless
# (gpu_flights), and makes a table for docs/measured.md of what it finds. Called by ./dev gpu.
#   gpu.sh BIN OUT [--quick]    BIN: folder of fjell-bake and gpu_flights; OUT: gets gpu.json, gpu.md and pictures
# Real height fields lie in FJELL_DATA (default: ../shared/data beside the checkout); without them the benchmarks' mountains
# take their place. --quick: small terrain and pictures, in seconds, to see that all of it works.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
bin=$1 out=$2 quick=${3:-}
data=${FJELL_DATA:-$root/../shared/data}
mkdir -p "$out/packs"
out=$(cd "$out" && pwd)
bake() { # PACK ARGUMENTS...: unless it is there
  [[ -e $out/packs/$1 ]] || "$bin/fjell-bake" "${@:2}" -o "$out/packs/$1" --quiet
}
scene() { # NAME PACK PATH FOV_DEG AZIMUTH_DEG ELEVATION_DEG RULES
  printf '{"name": "%s", "pack": "%s", "path": "%s", "fov_deg": %s, "azimuth_deg": %s, "elevation_deg": %s, "rules": "%s"}' \
    "$1" "$out/packs/$2" "$root/content/paths/$3.json" "$4" "$5" "$6" "$root/content/materials/rules/$7.json"
}

ground=mountains mountains=$root/content/terrain/mountains.json tile=4096 tiles=256
sizes='[[1920, 1080], [3840, 2160]]' patch_size='[1920, 1080]' triangles='[1000000, 4000000]' material_size=512
smaller=3 # in software: 640 x 360 and 1280 x 720
if [[ $quick == --quick ]]; then
  ground=small mountains=$out/packs/small.json tile=256 tiles=64
  echo '{"columns": 257, "rows": 257, "spacing_m": 60, "seed": 7, "relief_m": 2500, "feature_m": 6000}' >"$mountains"
  sizes='[[96, 54], [192, 108]]' patch_size='[320, 180]' triangles='[20000, 40000]' material_size=32
  smaller=1
fi
bake "$ground-one.fjell" "$mountains" --tile "$tile"
bake "$ground-tiles.fjell" "$mountains" --tile "$tiles"
materials=$out/packs/ground-$material_size.fjell-materials
[[ -e $materials ]] || "$bin/fjell-bake" materials "$root/content/materials" -o "$materials" --size "$material_size" --quiet

dem=$data/dem
if [[ $quick != --quick && -e $dem/grand_canyon_60m_4097x2049_u8.png ]]; then
  terrain='the gallery'
  bake canyon.fjell "$dem/grand_canyon_60m_4097x2049_u8.png" --spacing 60 --zscale 14.4 --zoffset 127 --bbox 2246,1628,3446,428 \
    --texture "$data/textures/grand_canyon_color_crop_1024.png" --horizons half
  bake jotunheimen.fjell "$dem/norway_jotunheimen_117m_512_f32.tif" --tile 128 --ramp "$root/content/ramps/alpine.json" --horizons half
  bake rainier.fjell "$dem/puget_sound_160m_1025_u16.png" --spacing 160 --zscale 0.1 --ramp "$root/content/ramps/cascades.json" --horizons half
  scenes="$(scene canyon canyon.fjell gallery-canyon 36 200 55 canyon),
    $(scene jotunheimen jotunheimen.fjell gallery-jotunheimen 32 120 10 alpine),
    $(scene rainier rainier.fjell gallery-rainier 24 80 5 alpine)"
else
  terrain='synthetic mountains in place of the gallery'
  bake "$ground-lit.fjell" "$mountains" --tile "$tiles" --ramp "$root/content/ramps/alpine.json" --horizons half
  scenes="$(scene along "$ground-lit.fjell" gallery-canyon 36 200 55 alpine),
    $(scene over "$ground-lit.fjell" flythrough 45 120 10 alpine),
    $(scene around "$ground-lit.fjell" orbit 45 80 5 alpine)"
  [[ $quick != --quick ]] || scenes=$(scene over "$ground-lit.fjell" flythrough 45 120 10 alpine)
fi
cat >"$out/plan.json" <<END
{"terrain": "$terrain", "profile": "$root/profiles/desktop.toml", "materials": "$materials", "sizes": $sizes, "smaller_in_software": $smaller,
 "scenes": [$scenes],
 "patches": {"one_tile": "$out/packs/$ground-one.fjell", "tiles": "$out/packs/$ground-tiles.fjell", "size": $patch_size,
             "error_px": 2, "triangles": $triangles}}
END
"$bin/gpu_flights" "$out/plan.json" "$out"
python3 "$root/tests/bench/gpu.py" "$out/gpu.json" >"$out/gpu.md"
