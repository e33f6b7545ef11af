# As the environment's CMAKE_TOOLCHAIN_FILE, so that commands stay as they are typed.
set(CMAKE_PROJECT_fjell_INCLUDE ${CMAKE_CURRENT_LIST_DIR}/../in_a_hurry.cmake)
