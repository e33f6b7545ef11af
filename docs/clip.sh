#!/usr/bin/env bash
# The clip at the top of README.md: the same flight shaded and as its mesh, and what each frame keeps.
#   docs/clip.sh BIN PACK OUT.webp     BIN: the folder of fjell-fly; PACK: rainier.fjell as docs/gallery.md bakes it
# Needs Debian's packages imagemagick, webp and fonts-dejavu-core.
set -euo pipefail
bin=$1 pack=$2 out=$3 frames=160
source=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fly() { # MODE OPTIONS...
  "$bin/fjell-fly" "$pack" --path "$source/content/paths/flight-rainier.json" --fov 30 --light azimuth_deg=80,elevation_deg=6 --headless \
    --stream on --wait --profile "$source/profiles/laptop.toml" --size 720x405 --samples 4 --frames $frames --render "$work/$1" --mode "$@" >/dev/null
}
fly shaded
fly wire --verify 1 --csv "$work/wire.csv"
column() { # NAME: of the flight's table
  awk -F, -v name="$1" 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) at = i } NR > 1 { print $at }' "$work/wire.csv"
}
paste -d, <(column frame) <(column verified_px) <(column triangles) <(column update_us) |
  while IFS=, read -r frame error triangles us; do
    name=$(printf 'frame_%05d.png' "$frame")
    text=$(LC_ALL=C awk -v e="$error" -v t="$triangles" -v u="$us" 'BEGIN {
      printf "error measured: %.2f px, 1.5 allowed\n%d,%03d triangles, %.1f ms", e, t / 1000, t % 1000, u / 1000 }')
    convert "$work/shaded/$name" \( "$work/wire/$name" -crop 360x405+360+0 +repage \) -gravity east -composite \
      -stroke white -draw 'line 360,0 360,405' -stroke none -fill white -font DejaVu-Sans -pointsize 15 \
      -gravity northwest -annotate +376+14 "$text" "$work/$name"
  done
img2webp -loop 0 -d 80 -lossy -q 70 -m 4 "$work"/frame_*.png -o "$out"
