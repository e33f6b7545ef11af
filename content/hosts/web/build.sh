#!/usr/bin/env bash
# build.sh PACKAGE FOLDER PACK...: the page as one folder of static files that any host can carry. PACKAGE: the folder
# with the npm package. PACK: what to fly over.
set -euo pipefail
package=$1 folder=$2
shift 2
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
npm=$folder-npm
mkdir -p "$folder"/{fjell,three,packs}
cp "$here"/{index.html,page.css,page.js,first.html,first.js} "$folder"
cp "$package"/{*.js,*.wasm} "$folder/fjell"
[[ -e $npm/node_modules/three ]] || {
  mkdir -p "$npm"
  cp "$here"/package{,-lock}.json "$npm"
  (cd "$npm" && npm ci --silent --no-audit --no-fund)
}
cp "$npm"/node_modules/three/build/three.{module,core}.min.js "$folder/three"
list=
for pack in "$@"; do
  name=$(basename "$pack" .fjell)
  cp "$pack" "$folder/packs/$name.fjell"
  list+="${list:+, }{ \"name\": \"${name^}\", \"url\": \"packs/$name.fjell\" }"
done
echo "[$list]" >"$folder/packs.json"
