# Toolchain: compiles for WebAssembly with Debian's emscripten; node runs the programs, which read the files of this machine.
include(/usr/share/emscripten/cmake/Modules/Platform/Emscripten.cmake)
set(CMAKE_CXX_FLAGS_INIT -msimd128)
set(CMAKE_EXE_LINKER_FLAGS_INIT "-sNODERAWFS=1 -sALLOW_MEMORY_GROWTH=1 -sEXIT_RUNTIME=1")
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE BOTH) # those that elsewhere/CMakeLists.txt makes
