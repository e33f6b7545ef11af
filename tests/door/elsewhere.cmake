# The library on another system: compiles all of it, and there the golden flight comes to what it comes to here.
#   cmake -DTOOLCHAIN=FILE -DFJELL=SOURCE -DSOURCES=FOLDER -DHEADERS=FOLDER -DFOLDER=BUILD -DBAKE=PROPERTY_CUT -DHERE=CUT_GOLDEN
#     -DPROGRAM=NAME -DRUNNER=COMMAND... -P elsewhere.cmake
# For Windows too: -DSPLIT=FJELL-BAKE -DSTREAMED=PROGRAM: fjell::io and fjell::profile say there what they say here.
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/must.cmake)
cmake_path(GET PROGRAM EXTENSION suffix)
full_rounds_only("the library for another system")
file(REMOVE_RECURSE ${FOLDER})
set(ENV{NODE_PATH} /usr/share/nodejs) # where Debian's emscripten finds its parts

# -O0: what is asked is whether it decides alike, and cut_golden_compilers asks that of every level.
must("configuring" ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/elsewhere -B ${FOLDER} -G Ninja -DCMAKE_TOOLCHAIN_FILE=${TOOLCHAIN}
  -DFJELL=${FJELL} -DSOURCES=${SOURCES} -DHEADERS=${HEADERS} -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS_RELEASE=-O0 -DNDEBUG"
  "-DCMAKE_C_FLAGS_RELEASE=-O0 -DNDEBUG")
must("building" ${CMAKE_COMMAND} --build ${FOLDER} -j 2)

# A place of its own for wine, without the copies of its libraries that it would make: it takes them from its own folder.
if(WINE_LIBRARIES)
  set(ENV{WINEPREFIX} ${FOLDER}/wine)
  set(ENV{WINEDEBUG} -all)
  file(MAKE_DIRECTORY ${FOLDER}/wine/drive_c/windows)
  file(WRITE ${FOLDER}/wine/.update-timestamp "disable\n")
  file(CREATE_LINK ${WINE_LIBRARIES} ${FOLDER}/wine/drive_c/windows/system32 SYMBOLIC)
endif()
set(pack ${FOLDER}/golden.fjell)
must("baking" ${CMAKE_COMMAND} -E env FJELL_GOLDEN_PACK=${pack} ${BAKE} [golden])
must("flying here" ${HERE} ${pack})
string(STRIP "${output}" here)
must("flying there" ${RUNNER} ${FOLDER}/${PROGRAM} ${pack})
string(STRIP "${output}" there)
must("sizes there" ${RUNNER} ${FOLDER}/sizes${suffix} ${pack})
message(STATUS "${output}")
if(WINE_LIBRARIES)
  must("splitting" ${SPLIT} split ${pack} -o ${FOLDER}/set)
  must("streaming here" ${STREAMED} ${pack} ${FOLDER}/set ${FOLDER}/files)
  set(streamed_here "${output}")
  file(REMOVE_RECURSE ${FOLDER}/files)
  must("streaming there" ${RUNNER} ${FOLDER}/streamed${suffix} ${pack} ${FOLDER}/set ${FOLDER}/files)
  string(REPLACE "\r" "" output "${output}")
  if(NOT output STREQUAL streamed_here OR NOT output MATCHES "place 4: [0-9a-f]+, [1-9].*who has it open keeps it.*whole")
    message(FATAL_ERROR "there it streams\n${output}\nand here\n${streamed_here}")
  endif()
  file(GLOB left ${FOLDER}/files/*/*)
  list(LENGTH left files)
  if(NOT files EQUAL 2)
    message(FATAL_ERROR "more is left than a pack and a profile: ${left}")
  endif()
endif()
file(REMOVE ${FOLDER}/wine/dosdevices/z:) # a link to all of this machine's files
if(NOT here MATCHES "^vector [0-9a-f]+ [0-9a-f]+ scalar [0-9a-f]+ [0-9a-f]+$" OR NOT there STREQUAL here)
  message(FATAL_ERROR "invariant 8: there it decides\n${there}\nand here\n${here}")
endif()
message(STATUS "${there}")
