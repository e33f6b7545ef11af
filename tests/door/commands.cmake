# Runs tests/door/commands.sh on a screen of its own.
#   cmake -DFOLDER=SCRATCH -DFJELL=SOURCE -DBIN=FOLDER -DXVFB=XVFB-RUN -P commands.cmake
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/must.cmake)
full_rounds_only("the guides' command lines; docs_test has looked at their flags")
must("the guides' commands" ${XVFB} -a -s "-screen 0 1280x1024x24" ${CMAKE_CURRENT_LIST_DIR}/commands.sh ${FJELL} ${BIN} ${FOLDER})
if(NOT output MATCHES "ran ([2-9][0-9]|[1-9][0-9][0-9]) commands")
  message(FATAL_ERROR "the guides have few commands: ${output}")
endif()
