# As the environment's CMAKE_TOOLCHAIN_FILE, so that commands stay as they are typed: how the library is compiled does
# not matter here.
set(CMAKE_CXX_FLAGS_DEBUG "" CACHE STRING "")
set(FJELL_ONE_PROCESSOR ON)
set(CMAKE_PROJECT_fjell_INCLUDE ${CMAKE_CURRENT_LIST_DIR}/../larger_pieces.cmake)
