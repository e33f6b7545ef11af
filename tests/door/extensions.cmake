# Headers and sources without the extensions that single compilers have: clang warns of GNU's, and reads them as MSVC
# does as far as the standard library here lets it. (-fms-compatibility does not: libstdc++ is not for it.) Headers
# also pass the warnings that a host may have made errors.
#   cmake -DCLANG=COMPILER -DCC=C -DFJELL=SOURCE -DBUILD=TREE -P extensions.cmake
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/must.cmake)
set(command ${CLANG} -std=c++20 -fsyntax-only -Werror -Wall -Wextra -Wpedantic -Wgnu -Wmicrosoft -fms-extensions -fdelayed-template-parsing
  -I${BUILD}/runtime/include)
foreach(folder src . include io/include profile/include gl/include gltf/include)
  list(APPEND command -I${FJELL}/runtime/${folder})
endforeach()
file(GLOB headers ${FJELL}/runtime/include/fjell/*.h ${FJELL}/runtime/*/include/fjell/*.h ${FJELL}/runtime/*/include/fjell/*/*.h)
set(text "")
foreach(header ${headers})
  string(APPEND text "#include \"${header}\"\n")
endforeach()
file(WRITE ${BUILD}/tests/door/extensions.cpp "${text}")
set(strict -Wconversion -Wsign-conversion -Wshadow -Wcast-qual -Wdouble-promotion -Wundef)
must("public headers" ${command} ${strict} -Wold-style-cast -Wzero-as-null-pointer-constant ${BUILD}/tests/door/extensions.cpp)
foreach(header include/fjell/fjell_c.h profile/include/fjell/live_c.h)
  must("${header}" ${CC} -std=c99 -fsyntax-only -Werror -Wall -Wextra -Wpedantic -Wstrict-prototypes -Wc++-compat ${strict}
    -I${BUILD}/runtime/include -I${FJELL}/runtime/include -x c ${FJELL}/runtime/${header})
endforeach()
file(WRITE ${BUILD}/tests/door/conversion.cpp "int f(double a) { return a; }\n")
must_fail("a conversion" "implicit conversion" ${command} ${strict} ${BUILD}/tests/door/conversion.cpp)
file(WRITE ${BUILD}/tests/door/extension.cpp "int f(int a) { return a ?: 1; }\n")
must_fail("an extension" "GNU [^\n]* extension" ${command} ${BUILD}/tests/door/extension.cpp)
full_rounds_only("the sources without extensions")
file(GLOB_RECURSE sources ${FJELL}/runtime/src/*.cpp ${FJELL}/runtime/io/*.cpp)
list(FILTER sources EXCLUDE REGEX "_windows.cpp|json.cpp")
foreach(source ${sources})
  must("${source}" ${command} ${source})
endforeach()
