# Installs the libraries: those that BUILD has built, or with SHARED=ON shared ones, built from FJELL here.
#   cmake -DPREFIX=FOLDER -DBUILD=TREE [-DSHARED=ON -DFJELL=SOURCE -DCOMPILER=C++ [-DOPTIONS=...]] -P install.cmake
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/must.cmake)
if(FJELL)
  full_rounds_only("building the libraries once more, shared")
  must("configuring" ${CMAKE_COMMAND} -S ${FJELL} -B ${BUILD} -G Ninja -DCMAKE_BUILD_TYPE=Debug -DFJELL_TOOLS=OFF
    -DBUILD_SHARED_LIBS=${SHARED} -DCMAKE_CXX_COMPILER=${COMPILER}
    -DCMAKE_PROJECT_fjell_INCLUDE=${CMAKE_CURRENT_LIST_DIR}/in_a_hurry.cmake ${OPTIONS})
  must("building" ${CMAKE_COMMAND} --build ${BUILD} -j 2)
endif()
file(REMOVE_RECURSE ${PREFIX})
must("installing" ${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX} --component fjell)
