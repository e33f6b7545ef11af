# What Fjell links, compiled from Debian's sources and found by find_package(), for systems that Debian has a compiler for
# and no libraries: WebAssembly, Windows. `./dev` fetches the sources.
#   SOURCES: the folder with highway and zstd. HEADERS: the folder with xxhash.h and, where they are asked for, others.
# fjell_header_package(PACKAGE TARGET FOLDER DEFINITION): a library that is headers alone.
add_library(hwy STATIC ${SOURCES}/highway/hwy/targets.cc)
target_include_directories(hwy SYSTEM PUBLIC ${SOURCES}/highway)
target_compile_features(hwy PUBLIC cxx_std_11)
add_library(hwy::hwy ALIAS hwy)
file(GLOB decoder ${SOURCES}/zstd/lib/common/*.c ${SOURCES}/zstd/lib/decompress/*.c)
add_library(libzstd_shared STATIC ${decoder})
target_include_directories(libzstd_shared SYSTEM PUBLIC ${SOURCES}/zstd/lib)
target_compile_definitions(libzstd_shared PRIVATE ZSTD_DISABLE_ASM)
add_library(zstd::libzstd_shared ALIAS libzstd_shared)

# find_package() finds them, and pkg-config the header of xxHash, which needs no library.
set(found ${CMAKE_CURRENT_BINARY_DIR}/found)
foreach(package hwy zstd)
  file(WRITE ${found}/${package}-config.cmake "")
  set(${package}_DIR ${found})
endforeach()
configure_file(${HEADERS}/xxhash.h ${found}/include/xxhash.h COPYONLY)
file(WRITE ${found}/libxxhash.pc "Name: xxhash\nDescription: header\nVersion: 0\nCflags: -I${found}/include -DXXH_INLINE_ALL\n")
set(ENV{PKG_CONFIG_LIBDIR} ${found})

function(fjell_header_package package target folder definition)
  file(WRITE ${found}/${package}-config.cmake "")
  file(COPY ${HEADERS}/${folder} DESTINATION ${found}/include)
  add_library(${package} INTERFACE)
  target_include_directories(${package} SYSTEM INTERFACE ${found}/include)
  target_compile_definitions(${package} INTERFACE ${definition}=1)
  add_library(${target} ALIAS ${package})
  set(${package}_DIR ${found} PARENT_SCOPE)
endfunction()
