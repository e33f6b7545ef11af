# No two classes of one name: builds tests/door/odr.
#   cmake -DFJELL=SOURCE -DFOLDER=BUILD -DCOMPILER=G++ [-DOPTIONS=...] -P odr.cmake
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/must.cmake)
full_rounds_only("compiling everything for link-time optimisation")
must("configuring" ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/odr -B ${FOLDER} -G Ninja -DFJELL=${FJELL}
  -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_AR=/usr/bin/gcc-ar -DCMAKE_RANLIB=/usr/bin/gcc-ranlib ${OPTIONS})
must("building and linking" ${CMAKE_COMMAND} --build ${FOLDER} -j 2 --target odr)
