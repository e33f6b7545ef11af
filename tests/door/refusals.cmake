# What a host is refused, and how it is told.
#   cmake -DSTATIC=PREFIX -DSHARED=PREFIX -DFOLDER=SCRATCH -DCOMPILER=C++ -DCC=C -DVERSION=V -DFJELL=SOURCE [-DCLANG=CLANG++]
#     [-DWINDOWS=TOOLCHAIN] -P refusals.cmake
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/must.cmake)
file(REMOVE_RECURSE ${FOLDER})

set(headers ${STATIC}/include)
file(WRITE ${FOLDER}/host.cpp "#include <fjell/fjell.h>\n")
must("a plain host" ${COMPILER} -std=c++20 -I${headers} -fsyntax-only ${FOLDER}/host.cpp)
file(GLOB publics ${headers}/fjell/*.h)
list(FILTER publics EXCLUDE REGEX "/glm.h$") # needs GLM
if("$ENV{FJELL_TEST_ROUNDS}" STREQUAL "full")
  foreach(public ${publics})
    must("${public} by itself" ${COMPILER} -std=c++20 -I${headers} -fsyntax-only -include ${public} -x c++ /dev/null)
  endforeach()
else() # compiling each is half of what is done here
  message(STATUS "skipped: each header by itself (FJELL_TEST_ROUNDS=full compiles them)")
  list(REVERSE publics) # no header relies on one that comes before it in the alphabet
  list(TRANSFORM publics PREPEND -include OUTPUT_VARIABLE included)
  must("all headers" ${COMPILER} -std=c++20 -I${headers} -fsyntax-only ${included} -x c++ /dev/null)
endif()
file(WRITE ${FOLDER}/host.c "#include <fjell/fjell_c.h>\n")
must("a plain host in C" ${CC} -std=c99 -Wall -Wextra -pedantic -Werror -I${headers} -fsyntax-only ${FOLDER}/host.c)
must("a host in C++11 that uses it" ${COMPILER} -std=c++11 -Wall -Wextra -pedantic -Werror -I${headers} -fsyntax-only -x c++ ${FOLDER}/host.c)
must_fail("32 bits from C" "Fjell needs 64 bits" ${CC} -std=c99 -m32 -ffreestanding -I${headers} -fsyntax-only ${FOLDER}/host.c)
foreach(flag -ffast-math -ffinite-math-only)
  must_fail(${flag} "must be compiled without -ffast-math" ${COMPILER} -std=c++20 ${flag} -I${headers} -fsyntax-only ${FOLDER}/host.cpp)
endforeach()
file(WRITE ${FOLDER}/small.cpp "#include <fjell/export.h>\n") # which all public headers include
must_fail("32 bits" "Fjell needs 64 bits" ${COMPILER} -std=c++20 -m32 -I${headers} -fsyntax-only ${FOLDER}/small.cpp)
if(CLANG) # which compiles for every processor
  set(big ${CLANG} --target=s390x-linux-gnu -ffreestanding -I${headers} -fsyntax-only)
  must_fail("a big-endian processor" "Fjell needs a little-endian processor" ${big} -std=c++20 ${FOLDER}/small.cpp)
  must_fail("a big-endian processor from C" "Fjell needs a little-endian processor" ${big} -x c -std=c99 ${FOLDER}/host.c)
else()
  message(STATUS "skipped: a big-endian processor (needs clang)")
endif()

# The project's version, everywhere: as a number in the header, in the packages of CMake and of pkg-config.
string(REGEX REPLACE "^([0-9]+)\\.([0-9]+)\\.([0-9]+)$" "\\1 * 1000000 + \\2 * 1000 + \\3" number "${VERSION}")
file(WRITE ${FOLDER}/version.cpp "#include <fjell/version.h>\nstatic_assert(FJELL_VERSION == ${number});\n")
must("the version as a number" ${COMPILER} -std=c++20 -I${headers} -fsyntax-only ${FOLDER}/version.cpp)
set(prefixes ${STATIC})
if("$ENV{FJELL_TEST_ROUNDS}" STREQUAL "full")
  list(APPEND prefixes ${SHARED})
endif()
foreach(prefix ${prefixes})
  foreach(package fjell fjell-io)
    must("pkg-config" ${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${prefix}/lib/pkgconfig pkg-config --modversion ${package})
    if(NOT output STREQUAL "${VERSION}\n")
      message(FATAL_ERROR "${prefix}: ${package}.pc has version ${output}")
    endif()
  endforeach()
endforeach()

# find_package(fjell ARGUMENTS) in an empty project that has PREFIX.
function(find arguments prefix)
  file(WRITE ${FOLDER}/find/CMakeLists.txt "cmake_minimum_required(VERSION 3.25)\nproject(find LANGUAGES CXX)\nfind_package(fjell ${arguments})\n")
  file(REMOVE_RECURSE ${FOLDER}/find/build)
  set(command ${CMAKE_COMMAND} -S ${FOLDER}/find -B ${FOLDER}/find/build -G Ninja -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_CXX_COMPILER=${COMPILER} ${ARGN}
    PARENT_SCOPE)
endfunction()
find("${VERSION} REQUIRED" ${STATIC})
must("this version" ${command})
find("0.3 REQUIRED COMPONENTS runtime io gl gltf" ${STATIC})
must("all components" ${command})
foreach(other 0.2 0.4 1.0) # before 1.0 a minor version may break
  find("${other} REQUIRED" ${STATIC})
  must_fail("version ${other}" "requested version \"${other}\"" ${command})
endforeach()
find("0.3 REQUIRED COMPONENTS physics" ${STATIC})
must_fail("an unknown component" "no component physics: there are runtime, io, profile, gl and gltf" ${command})
find("0.3 REQUIRED" ${STATIC} -DCMAKE_DISABLE_FIND_PACKAGE_hwy=ON)
must_fail("a library that is missing" "component runtime needs hwy: install it" ${command})

# A host in C, whose languages are the links' too.
set(languages "(a static Fjell needs the C\\+\\+ linker|Fjell is compiled as C\\+\\+): write project\\(host LANGUAGES C CXX\\)")
foreach(way "find_package(fjell 0.3 REQUIRED)" "add_subdirectory(${FJELL} fjell)")
  file(WRITE ${FOLDER}/c/CMakeLists.txt "cmake_minimum_required(VERSION 3.25)\nproject(host LANGUAGES C)\n${way}\n")
  file(REMOVE_RECURSE ${FOLDER}/c/build)
  must_fail("a host in C: ${way}" "${languages}" ${CMAKE_COMMAND} -S ${FOLDER}/c -B ${FOLDER}/c/build -G Ninja
    -DCMAKE_C_COMPILER=${CC} -DCMAKE_PREFIX_PATH=${STATIC})
endforeach()

full_rounds_only("asking an installation for what it was built without")
find("0.3 REQUIRED COMPONENTS gl" ${SHARED})
must_fail("a component that was not built" "component gl was not built: configure Fjell with -DFJELL_GL=ON" ${command})

# Where the library cannot be is said while configuring, before anything is compiled.
function(must_not_configure what text)
  file(REMOVE_RECURSE ${FOLDER}/elsewhere)
  must_fail("configuring for ${what}" "${text}" ${CMAKE_COMMAND} -S ${FJELL} -B ${FOLDER}/elsewhere -G Ninja -DFJELL_TOOLS=OFF
    -DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY ${ARGN})
endfunction()
must_not_configure("32 bits" "Fjell needs 64 bits, or WebAssembly" -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_FLAGS=-m32)
if(CLANG)
  must_not_configure("a big-endian processor" "Fjell needs a little-endian processor" -DCMAKE_CXX_COMPILER=${CLANG}
    -DCMAKE_CXX_COMPILER_TARGET=s390x-linux-gnu)
endif()
if(WINDOWS)
  must_not_configure("Windows with the tools" "the tools call POSIX: set FJELL_TOOLS to OFF" -DCMAKE_TOOLCHAIN_FILE=${WINDOWS} -DFJELL_TOOLS=ON)
  must_not_configure("Windows as a shared library" "set BUILD_SHARED_LIBS to OFF" -DCMAKE_TOOLCHAIN_FILE=${WINDOWS} -DBUILD_SHARED_LIBS=ON)
else()
  message(STATUS "skipped: what is refused for Windows (needs mingw-w64)")
endif()
