#!/usr/bin/env bash
# The commands of docs/guides/embedding.md, as they stand there, in a folder with a game's sources, a pack, and Fjell as
# `fjell`. Home is that folder too.
set -euo pipefail
CMAKE_TOOLCHAIN_FILE=$(realpath "$(dirname "${BASH_SOURCE[0]}")/by_hand/toolchain.cmake")
export CMAKE_TOOLCHAIN_FILE HOME=$PWD CMAKE_GENERATOR=Ninja CMAKE_BUILD_PARALLEL_LEVEL=2 CMAKE_BUILD_TYPE=Debug

if [[ ${1:-} == folder ]]; then
  cmake -S . -B build
  exit
fi

cmake -S fjell -B fjell-build -DFJELL_TOOLS=OFF -DFJELL_GL=ON -DFJELL_PROFILE=ON
cmake --build fjell-build
cmake --install fjell-build --prefix ~/fjell-0.3

cmake -S fjell/content/hosts/first -B first-build -DCMAKE_PREFIX_PATH=~/fjell-0.3
cmake --build first-build
first-build/picture terrain.fjell fjell/profiles/laptop.toml first.png

cmake -S fjell/content/hosts/game -B game-build -DCMAKE_PREFIX_PATH=~/fjell-0.3
cmake --build game-build
game-build/game terrain.fjell picture.png

export PKG_CONFIG_PATH=~/fjell-0.3/lib/pkgconfig
g++ -std=c++20 engine.cpp main.cpp -o game $(pkg-config --cflags --libs fjell-io)
./game terrain.fjell

cmake -S fjell/content/hosts/c_loop -B c_loop-build -DCMAKE_PREFIX_PATH=~/fjell-0.3
cmake --build c_loop-build

cc -std=c99 -c fjell/content/hosts/c_loop/*.c $(pkg-config --cflags fjell glfw3 epoxy)
c++ main.o draw.o -o c_loop $(pkg-config --libs fjell glfw3 epoxy) -lm

[[ ${DISPLAY:-} ]] || { echo "skipped: the host in C, which opens a window (there is no display)"; exit; }
first-build/first terrain.fjell fjell/profiles/laptop.toml & first=$!
xdotool search --sync --onlyvisible --name '^first$' windowfocus keydown Escape
wait $first

c_loop-build/c_loop terrain.fjell picture.ppm 120
./c_loop terrain.fjell picture.ppm 120
