#!/bin/sh
# What the README's plots show, measured and drawn: docs/plots.json and docs/pictures/plot-*.svg. Called by ./dev plots.
#
#   plots.sh BIN OUT    BIN: folder of fjell-lab and bench_cut; OUT: folder of what is measured
set -eu
bin=$1 out=$2
cd "$(dirname "$0")/../.."
mkdir -p "$out"
"$bin/bench_cut" --benchmark_filter=cut/jumps --benchmark_out="$out/jumps.json" --benchmark_out_format=json
"$bin/fjell-lab" --recipes content/experiments/readme --out "$out" --fresh
python3 tests/bench/plots.py "$out" docs/plots.json
"$bin/fjell-lab" --draw docs/plots.json --out docs/pictures
