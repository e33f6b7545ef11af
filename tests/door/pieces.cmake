# The runtime's sources in groups that can be compiled as one: most of compiling them without optimisation, and of
# clang-tidy, is reading headers. By themselves are what Highway compiles once a processor (it names its own file), what
# asks zstd for more, and what names a type as another source does.
#
#   cmake -DSRC=FOLDER -DFOLDER=FOLDER -P pieces.cmake writes them into FOLDER, and prints what to compile.
cmake_minimum_required(VERSION 3.25)

# fjell_pieces(SRC): sets `pieces`, names of groups; for each piece_NAME, its files; and `apart`.
function(fjell_pieces src)
  set(pieces cut recursive stream c pack edit shared)
  foreach(piece ${pieces})
    set(piece_${piece} "")
  endforeach()
  set(apart "")
  file(GLOB_RECURSE files ${src}/*.cpp)
  foreach(file ${files})
    cmake_path(RELATIVE_PATH file BASE_DIRECTORY ${src} OUTPUT_VARIABLE name)
    cmake_path(GET name PARENT_PATH folder)
    file(STRINGS ${file} once_a_processor REGEX "hwy/foreach_target.h")
    if(NOT folder OR folder STREQUAL "view")
      set(folder shared)
    endif()
    if(once_a_processor OR NOT folder IN_LIST pieces OR name MATCHES "^(pack/terrain|stream/requests|edit/edits|edit/ground_maps|edit/normals)\\.cpp$")
      list(APPEND apart ${file})
    else()
      list(APPEND piece_${folder} ${file})
    endif()
  endforeach()
  set(pieces ${pieces} PARENT_SCOPE)
  set(apart ${apart} PARENT_SCOPE)
  foreach(piece ${pieces})
    set(piece_${piece} ${piece_${piece}} PARENT_SCOPE)
  endforeach()
endfunction()

# fjell_write_pieces(SRC FOLDER): writes a source a group into FOLDER, and sets `sources`, these and those apart.
function(fjell_write_pieces src folder)
  fjell_pieces(${src})
  set(sources ${apart})
  foreach(piece ${pieces})
    list(TRANSFORM piece_${piece} REPLACE "(.+)" "#include \"\\1\"")
    list(JOIN piece_${piece} "\n" text)
    file(WRITE ${folder}/${piece}.cpp "${text}\n")
    list(APPEND sources ${folder}/${piece}.cpp)
  endforeach()
  set(sources ${sources} PARENT_SCOPE)
endfunction()

if(CMAKE_SCRIPT_MODE_FILE STREQUAL CMAKE_CURRENT_LIST_FILE)
  fjell_write_pieces(${SRC} ${FOLDER})
  list(JOIN sources "\n" text)
  execute_process(COMMAND ${CMAKE_COMMAND} -E echo "${text}")
endif()
