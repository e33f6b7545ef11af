#!/usr/bin/env bash
# build.sh SOURCES HEADERS FOLDER: the npm package `fjell`, as a folder FOLDER/package and as npm packs it,
# FOLDER/fjell-VERSION.tgz. SOURCES: zstd and Highway, which `./dev web` fetches. HEADERS: where xxhash.h and fmt are.
set -euo pipefail
sources=$1 headers=$2 folder=$3
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$here/../..
emscripten=/usr/share/emscripten/cmake/Modules/Platform/Emscripten.cmake
export NODE_PATH=/usr/share/nodejs # where Debian's emscripten finds its parts
mkdir -p "$folder"

module() { # SIMD OPTIMISATION FILE
  local build=$folder/simd-$1
  cmake -S "$here" -B "$build" -G Ninja -DCMAKE_TOOLCHAIN_FILE=$emscripten -DCMAKE_FIND_ROOT_PATH_MODE_PACKAGE=BOTH \
    -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS_RELEASE=$2 -DNDEBUG" "-DCMAKE_C_FLAGS_RELEASE=$2 -DNDEBUG" \
    -DFJELL="$root" -DSOURCES="$sources" -DHEADERS="$headers" -DSIMD="$1" >"$build.log" 2>&1 &&
    cmake --build "$build" -j 2 >>"$build.log" 2>&1 || {
    cat "$build.log" >&2
    return 1
  }
  cp "$build/fjell.wasm" "$folder/package/$3"
}

version=$(sed -n 's/^project(fjell VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")
rm -rf "$folder/package"
mkdir -p "$folder/package"
module ON "-O3 -flto" fjell.wasm
module OFF "-Oz -flto" fjell-scalar.wasm
wasm-opt -Oz --converge "$folder/package/fjell-scalar.wasm" -o "$folder/package/fjell-scalar.wasm" # a kilobyte and a half
cp "$here"/package/*.js "$here"/package/*.d.ts "$here/package/README.md" "$root/LICENSE" "$folder/package"
sed -i -E 's/^ +//' "$folder"/package/*.{js,d.ts} # indentation and comments take a kilobyte each
sed -i '/^\/\//d' "$folder"/package/*.js
for file in package.json version.js; do
  sed "s/@FJELL_VERSION@/$version/" "$here/package/$file.in" >"$folder/package/$file"
done
rm -f "$folder"/*.tgz
(cd "$folder/package" && npm pack --silent --pack-destination ..)
