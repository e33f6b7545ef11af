# The runtime in larger pieces, folder by folder, where the point is not how it is compiled: most of compiling it without
# optimisation is reading headers. Not what Highway compiles once a processor (it names its own file), nor what asks zstd
# for more, nor queries, which name their types alike. As CMAKE_PROJECT_fjell_INCLUDE, or behind add_subdirectory.
function(fjell_in_larger_pieces)
  get_target_property(source fjell_runtime SOURCE_DIR)
  set_target_properties(fjell_runtime PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  foreach(folder cut recursive stream c pack)
    file(GLOB sources ${source}/src/${folder}/*.cpp)
    list(FILTER sources EXCLUDE REGEX "/(terrain|stream/create|requests).cpp$")
    foreach(file ${sources})
      file(STRINGS ${file} once_a_processor REGEX "hwy/foreach_target.h")
      if(NOT once_a_processor)
        set_source_files_properties(${file} TARGET_DIRECTORY fjell_runtime PROPERTIES UNITY_GROUP ${folder})
      endif()
    endforeach()
  endforeach()
endfunction()
cmake_language(DEFER DIRECTORY ${PROJECT_SOURCE_DIR} CALL fjell_in_larger_pieces)
