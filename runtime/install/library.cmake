# What a host links, from this tree or installed: static, or shared with BUILD_SHARED_LIBS.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(fjell_config_folder ${CMAKE_INSTALL_LIBDIR}/cmake/fjell)

# fjell_library(TARGET NAME): TARGET becomes fjell::NAME, a component of find_package(fjell), its headers in include/fjell.
function(fjell_library target name)
  add_library(fjell::${name} ALIAS ${target})
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:fjell_options>)
  # A static library may become a part of the host's shared one: position-independent, and without symbols of its own
  # there. SOVERSION: before 1.0 a minor version may break.
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON
    CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} INSTALL_RPATH $ORIGIN)
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "STATIC_LIBRARY")
    target_compile_definitions(${target} PRIVATE FJELL_STATIC_BUILD)
  else()
    target_compile_options(${target} PRIVATE -fno-semantic-interposition) # calls inside the library stay inside
  endif()
  if(FJELL_INSTALL)
    install(TARGETS ${target} EXPORT fjell-${name}-targets COMPONENT fjell
      ARCHIVE COMPONENT fjell LIBRARY COMPONENT fjell)
    install(DIRECTORY include/fjell TYPE INCLUDE COMPONENT fjell FILES_MATCHING PATTERN *.h)
    install(EXPORT fjell-${name}-targets NAMESPACE fjell:: DESTINATION ${fjell_config_folder} COMPONENT fjell)
  endif()
endfunction()

# fjell_links(TARGET LIBRARIES...): what TARGET needs of others, and its headers do not. A host of the static library
# links these too. One of the shared library never hears of them: linked by target they would be named in its export.
function(fjell_links target)
  get_target_property(type ${target} TYPE)
  foreach(library ${ARGN})
    get_target_property(library_type ${library} TYPE)
    if(type STREQUAL "STATIC_LIBRARY" OR library_type STREQUAL "INTERFACE_LIBRARY")
      target_link_libraries(${target} PRIVATE ${library})
    else()
      target_link_libraries(${target} PRIVATE $<TARGET_LINKER_FILE:${library}>)
      target_include_directories(${target} SYSTEM PRIVATE $<TARGET_PROPERTY:${library},INTERFACE_INCLUDE_DIRECTORIES>)
      target_compile_definitions(${target} PRIVATE $<TARGET_PROPERTY:${library},INTERFACE_COMPILE_DEFINITIONS>)
    endif()
  endforeach()
endfunction()

# fjell_pkg_config(FILE TARGET DESCRIPTION OURS OTHERS): FILE.pc, movable with its folder. OURS: packages of ours that
# its headers include; OTHERS: what a static library needs besides. They are plain Requires there, not Requires.private:
# whoever has only the static library would else need to know about `pkg-config --static`. What follows: flags for
# those of them that have no .pc file.
function(fjell_pkg_config file target description ours others)
  if(NOT FJELL_INSTALL)
    return()
  endif()
  get_target_property(type ${target} TYPE)
  set(requires ${ours})
  set(flags "")
  if(type STREQUAL "STATIC_LIBRARY")
    list(APPEND requires ${others})
    list(JOIN ARGN " " flags)
  endif()
  list(JOIN requires ", " requires)
  file(RELATIVE_PATH to_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
  string(REGEX REPLACE "/$" "" to_prefix ${to_prefix})
  configure_file(${PROJECT_SOURCE_DIR}/runtime/install/fjell.pc.in ${file}.pc @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${file}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT fjell)
endfunction()
