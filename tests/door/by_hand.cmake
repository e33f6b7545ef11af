# What the guide says to type, typed.
#   cmake -DFOLDER=SCRATCH -DFJELL=SOURCE -DPACK=FILE -P by_hand.cmake
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/must.cmake)
file(REMOVE_RECURSE ${FOLDER})
file(MAKE_DIRECTORY ${FOLDER})
file(COPY ${CMAKE_CURRENT_LIST_DIR}/host/engine.h ${CMAKE_CURRENT_LIST_DIR}/host/engine.cpp ${CMAKE_CURRENT_LIST_DIR}/host/main.cpp
  ${CMAKE_CURRENT_LIST_DIR}/by_hand/CMakeLists.txt DESTINATION ${FOLDER})
file(CREATE_LINK ${FJELL} ${FOLDER}/fjell SYMBOLIC)
file(CREATE_LINK ${PACK} ${FOLDER}/terrain.fjell SYMBOLIC)
must("the guide's folder" ${CMAKE_COMMAND} -E chdir ${FOLDER} ${CMAKE_CURRENT_LIST_DIR}/by_hand.sh folder)
full_rounds_only("building the library by hand")
must("the guide's commands" ${CMAKE_COMMAND} -E chdir ${FOLDER} ${CMAKE_CURRENT_LIST_DIR}/by_hand.sh)
if(NOT output MATCHES "\nconverged 1: " OR NOT output MATCHES "\nstreamed: " OR NOT EXISTS ${FOLDER}/picture.png OR
    NOT EXISTS ${FOLDER}/first.png)
  message(FATAL_ERROR "the guide's commands say: ${output}")
endif()
