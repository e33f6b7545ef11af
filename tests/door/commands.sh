#!/usr/bin/env bash
# Every command line of the README and the guides, in their order, in a folder with the files that they name.
#   commands.sh REPOSITORY BIN SCRATCH   (a display is needed; windows are interrupted after some seconds)
set -euo pipefail
readonly repository=$1 scratch=$3
export PATH=$2:$PATH HOME=$3
rm -rf "$scratch"
mkdir -p "$scratch"
cd "$scratch"
ln -s "$repository"/{content,profiles} .

fjell-bake synth content/terrain/mountains-small.json -o dem.tif
gdal_translate -q -a_srs EPSG:32632 -a_ullr 430000 6800000 460780 6769220 dem.tif terrain.tif # in Norway
gdal_translate -q -of PNG -ot Byte -scale -outsize 600 600 dem.tif image.png
gdal_translate -q -ot Int16 -outsize 372 330 -a_nodata -32767 dem.tif craterlake_elev_i16_30m.tif # made up, too
# Hills, and -9999 in a corner without a word about it.
{
  printf 'ncols 70\nnrows 50\nxllcorner 0\nyllcorner 0\ncellsize 30\n'
  awk 'BEGIN { for (y = 0; y < 50; ++y) for (x = 0; x < 70; ++x) print x + y < 20 ? -9999 : 100 + 40 * sin(x / 9) * cos(y / 7) }'
} >basin.asc
for west in 6 7; do # two degrees of the Alps, made up
  gdal_translate -q -of SRTMHGT -ot Int16 -outsize 1201 1201 -a_srs EPSG:4326 -a_ullr "$(awk "BEGIN { print $west - 1 / 2400 }")" \
    47.000416667 "$(awk "BEGIN { print $west + 1 + 1 / 2400 }")" 45.999583333 dem.tif "N46E00$west.hgt"
done
echo '{"type": "Polygon", "coordinates": [[[7.85, 61.12], [8.1, 61.15], [7.95, 61.24], [7.85, 61.12]]]}' >valley.geojson
for lines in roads rivers; do # metres, as dem.tif has no CRS
  echo '{"type": "LineString", "coordinates": [[3000, -4000], [9000, -7000], [14000, -16000]]}' >$lines.geojson
  ogr2ogr $lines.gpkg $lines.geojson
done

ran=0
run() { # PAGE LINE
  local code=0 allowed=0
  case $2 in
    './dev '*) return ;; # tests of their own
    *fjell-bake* | *--headless* | *--screenshot*) timeout 600 bash -c "$2" >said.txt 2>&1 || code=$? ;;
    *) # a window
      timeout -s INT 3 bash -c "exec $2" >said.txt 2>&1 || code=$?
      allowed=124
      ;;
  esac
  ran=$((ran + 1))
  if ((code != 0 && code != allowed)); then
    tail -n 5 said.txt >&2
    echo "$1: exit code $code: $2" >&2
    exit 1
  fi
}
for page in README.md docs/guides/{first-picture,baking,tuning,exporting,tiles}.md; do
  while IFS= read -r -u 3 line; do
    echo "$page: $line"
    run "$page" "$line"
  done 3< <(awk '/^```/ { inside = !inside; plain = $0 == "```"; next } inside && plain' "$repository/$page")
done
echo "ran $ran commands"
