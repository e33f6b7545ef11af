# No two classes of one name: builds tests/door/odr.
#   cmake -DFJELL=SOURCE -DFOLDER=BUILD -DCOMPILER=G++ [-DOPTIONS=...] -P odr.cmake
cmake_minimum_required(VERSION 3.25)
if(NOT "$ENV{FJELL_TEST_ROUNDS}" STREQUAL "full")
  message(STATUS "skipped: compiling everything for link-time optimisation (FJELL_TEST_ROUNDS=full does)")
  return()
endif()
include(${CMAKE_CURRENT_LIST_DIR}/must.cmake)
must("configuring" ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/odr -B ${FOLDER} -G Ninja -DFJELL=${FJELL}
  -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_AR=/usr/bin/gcc-ar -DCMAKE_RANLIB=/usr/bin/gcc-ranlib ${OPTIONS})
must("building and linking" ${CMAKE_COMMAND} --build ${FOLDER} -j 2 --target odr)
