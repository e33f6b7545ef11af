# What content/hosts/ogre does once it is built: what it prints and draws, what it refuses, and that it notices a
# mistake. Of door.cmake.
set(host ${FOLDER}/ogre)

# must_end(CODE TEXT ARGUMENTS...): it ends with that code and that line on its standard error.
function(must_end code text)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE ended OUTPUT_VARIABLE output ERROR_VARIABLE errors TIMEOUT 300)
  if(NOT ended EQUAL code OR NOT errors MATCHES "ogre: ${text}\n$")
    message(FATAL_ERROR "the host with OGRE ends with ${ended} and says ${output}${errors}where ${code} and \"${text}\" are expected")
  endif()
endfunction()

set(picture ${FOLDER}/picture.ppm)
must("flying" ${XVFB} -a ${host} ${PACK} ${picture} 400)
if(NOT output MATCHES "^[0-9]+ us to update, [0-9]+ us to copy ([0-9]+) bytes a frame
([0-9]+) vertices; OGRE draws ([0-9]+) triangles, the cut has ([0-9]+) in view. the origin moved ([0-9]+) times
([0-9]+) rays to the ground and ([0-9]+) to the sky, 0 of them not as drawn
boulders and their shadows: ([0-9]+) pixels, ([0-9]+) of them much darker
$")
  message(FATAL_ERROR "the host with OGRE says: ${output}")
endif()
set(copied ${CMAKE_MATCH_1})
if(CMAKE_MATCH_2 LESS 3000 OR NOT CMAKE_MATCH_3 EQUAL CMAKE_MATCH_4 OR CMAKE_MATCH_5 LESS 2 OR CMAKE_MATCH_6 LESS 2000
   OR CMAKE_MATCH_7 LESS 1000 OR CMAKE_MATCH_8 LESS 10000 OR CMAKE_MATCH_9 LESS 3000 OR copied GREATER 200000)
  message(FATAL_ERROR "the host with OGRE has not seen enough: ${output}")
endif()
file(SIZE ${picture} bytes)
if(NOT bytes EQUAL 1555215) # 960 x 540 pixels and a head of 15 bytes
  message(FATAL_ERROR "a picture of ${bytes} bytes")
endif()

must_end(1 "usage: ogre PACK PICTURE.ppm \\[FRAMES \\[PAGES\\]\\]" ${host})
must_end(1 "pack: nowhere.fjell: [^\n]+" ${host} nowhere.fjell ${picture})
must_end(1 "OGRE: Couldn`t open X display *" ${CMAKE_COMMAND} -E env --unset=DISPLAY ${host} ${PACK} ${picture})
must_end(1 "picture: ${FOLDER}/nowhere/picture.ppm: cannot be written" ${XVFB} -a ${host} ${PACK} ${FOLDER}/nowhere/picture.ppm 20)

# Some of what was written is not copied: then the ground is not where rays meet it.
must("planting a mistake" ${CMAKE_COMMAND} -DPLANT=PLANT_FORGET ${FOLDER})
must("building with a mistake" ${CMAKE_COMMAND} --build ${FOLDER} -j 2)
must_end(1 "picture: the ground is not where rays meet it" ${XVFB} -a ${host} ${PACK} ${picture} 400)
