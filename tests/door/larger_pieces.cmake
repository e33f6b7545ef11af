# The runtime in larger pieces (pieces.cmake), where the point is not how it is compiled. As CMAKE_PROJECT_fjell_INCLUDE,
# or behind add_subdirectory.
include(${CMAKE_CURRENT_LIST_DIR}/pieces.cmake)
function(fjell_in_larger_pieces)
  get_target_property(source fjell_runtime SOURCE_DIR)
  set_target_properties(fjell_runtime PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  fjell_pieces(${source}/src)
  foreach(piece ${pieces})
    set_source_files_properties(${piece_${piece}} TARGET_DIRECTORY fjell_runtime PROPERTIES UNITY_GROUP ${piece})
  endforeach()
endfunction()
cmake_language(DEFER DIRECTORY ${PROJECT_SOURCE_DIR} CALL fjell_in_larger_pieces)
