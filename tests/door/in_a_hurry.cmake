# As CMAKE_PROJECT_fjell_INCLUDE, where Fjell has to be there and it does not matter how it is compiled: in larger pieces,
# for one kind of processor, without debug information. A third of the time.
set(CMAKE_UNITY_BUILD ON)
set(CMAKE_UNITY_BUILD_BATCH_SIZE 12)
set(CMAKE_CXX_FLAGS_DEBUG "")
add_compile_definitions(HWY_COMPILE_ONLY_STATIC)
include(${CMAKE_CURRENT_LIST_DIR}/larger_pieces.cmake)
