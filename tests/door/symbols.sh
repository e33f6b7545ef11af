#!/usr/bin/env bash
# What a library shows is what symbols.txt lists, and what fjell_c.h declares; and C has all that C++ has.
#   symbols.sh LIST HEADER ARCHIVE SHARED
# ARCHIVE: the static library, whose functions for C are compared in every run. SHARED: all of the shared one, in full
# rounds, which build it.
# To write the list anew after a change: symbols.sh --list SHARED >tests/door/symbols.txt
set -euo pipefail

shown() { # LIBRARY OPTIONS...: functions and data, by their names in C or C++; inline ones depend on the compiler
  nm -C --defined-only "${@:2}" "$1" | sed -n 's/^[0-9a-f]* [TDBRi] //p' | LC_ALL=C sort -u
}
if [[ $1 == --list ]]; then
  shown "$2" -D
  exit
fi
list=$1 header=$2 archive=$3 shared=$4

same() { # WHAT EXPECTED FOUND: two lists
  local difference
  if ! difference=$(diff --label symbols.txt --label "$1" -U0 "$2" "$3"); then
    echo "$difference" >&2
    echo "$1 and tests/door/symbols.txt differ: a symbol that goes breaks hosts (CHANGELOG.md); symbols.sh says how to write the list" >&2
    exit 1
  fi
}
c_names() { grep -E '^fjell_[a-z0-9_]+$' || true; }
same "the static library" <(c_names <"$list") <(shown "$archive" -g 2>/dev/null | c_names)
same "fjell_c.h" <(c_names <"$list") <(sed 's,//.*,,' "$header" | grep -oE '\bfjell_[a-z0-9_]+\(' | tr -d '(' | LC_ALL=C sort -u)

# fjell::update_cut() is fjell_update_cut(), Terrain::rows() is fjell_terrain_rows(). What C names otherwise:
declare -A otherwise=(
  [budget_field]='cut_budget_field stream_budget_field' [validate]='validate_view validate_cut_settings'
  [bound_error_px]='bound_cut_error_px bound_recursive_error_px'
  [length]='' [normalised]='' # the host has vectors of its own
  [TerrainData::vertex]='' [TerrainData::ground_m]='' # for our companions
)
while read -r name; do
  for c in ${otherwise[$name]-$name}; do
    grep -qx "fjell_$c" "$list" || { echo "there is no fjell_$c for fjell::$name" >&2 && exit 1; }
  done
done < <(sed -nE 's/^fjell::([A-Za-z_:]+)\(.*/\1/p' "$list" | sed 's/^Terrain::/terrain_/; s/^Pack::/pack_/' | sort -u)

if [[ ${FJELL_TEST_ROUNDS:-} == full ]]; then
  same "the shared library" "$list" <(shown "$shared" -D)
else
  echo "skipped: the shared library's symbols (FJELL_TEST_ROUNDS=full compares them)"
fi
