# Input that is bad, in every host: each shows a sentence that says what is wrong, and none crashes. In full rounds. Of
# door.cmake, behind building: HOST, FOLDER, PACK, FAULTS, XVFB.
get_filename_component(host ${HOST} NAME)
set(program ${FOLDER}/${host})
set(bad ${FOLDER}/bad)
file(MAKE_DIRECTORY ${bad})

# What it is given behind the pack, and what makes its budget too small. FROM: how many reads of the pack go well before
# one page and all that follow are lost.
if(host STREQUAL "game")
  set(few ${bad}/picture.png 30 3)
  set(usual ${bad}/picture.png 30)
  set(from 12)
elseif(host STREQUAL "c_loop") # it reads the pack at once
  set(few ${bad}/picture.ppm 5 3)
  set(usual ${bad}/picture.ppm 5)
  set(from 1)
elseif(host STREQUAL "vulkan")
  set(few ${bad}/picture.ppm 30 3)
  set(usual ${bad}/picture.ppm 30)
  set(from 90)
elseif(host STREQUAL "ogre")
  set(few ${bad}/picture.ppm 30 3)
  set(usual ${bad}/picture.ppm 60)
  set(from 100)
else()
  set(few 2 3)
  set(usual 2) # seconds: on a busy machine not every page is read in them
  set(from 20)
endif()
set(display "")
if(host MATCHES "c_loop|ogre")
  set(display ${XVFB} -a)
endif()

# must_say(CODES TEXT COMMAND...): it ends with one of these codes, one of its lines of errors matches, and the last is its
# own.
function(must_say codes text)
  execute_process(COMMAND ${display} ${ARGN} RESULT_VARIABLE ended OUTPUT_VARIABLE output ERROR_VARIABLE errors TIMEOUT 120)
  if(NOT ended MATCHES "^(${codes})$" OR NOT errors MATCHES "(^|\n)${host}: ${text}\n" OR NOT errors MATCHES "(^|\n)${host}: [^\n]+\n$")
    message(FATAL_ERROR "${host} ends with ${ended} and says ${output}${errors}where ${codes} and \"${text}\" are expected")
  endif()
endfunction()

set(tiled ${bad}/tiled.fjell) # of many tiles, so that a budget can be too small for the coarsest mesh
if(host MATCHES "game|c_loop|vulkan")
  must("baking" ${BAKE} ${RECIPE} --tile 64 -o ${tiled} --quiet)
else()
  configure_file(${PACK} ${tiled} COPYONLY)
endif()
must("another version" bash -c "cp '${tiled}' '${bad}/old.fjell' && printf '\\003' | dd of='${bad}/old.fjell' bs=1 seek=8 conv=notrunc status=none")
must("half a pack" bash -c "head -c 60000 '${tiled}' >'${bad}/half.fjell'")
file(WRITE ${bad}/empty.fjell "")
must_say("1|3" "[^\n]*none.fjell: (cannot be opened|No such file or directory). give [^\n]+" ${program} ${bad}/none.fjell ${usual})
must_say("1|3" "[^\n]*bad: (cannot be (opened|read)|is a folder)[^\n]+" ${program} ${bad} ${usual})
must_say("1|3" "[^\n]*version: the pack was written by another version of fjell-bake. bake it again with this one: fjell-bake HEIGHTS -o PACK" ${program} ${bad}/old.fjell ${usual})
must_say("1|3" "[^\n]*file_bytes: the pack ends too early. copy or bake it again" ${program} ${bad}/half.fjell ${usual})
must_say("1|3" "[^\n]+. (give|bake|copy) [^\n]+" ${program} ${bad}/empty.fjell ${usual})
must_say("1|3" "[^\n]*Budget::[a-z_]+ \\([^\n]*a tile\\): the budget cannot hold the coarsest mesh. raise the field" ${program} ${tiled} ${few})
must_say("1|2" "[^\n]*--times: cannot open VIEWS. [^\n]+" ${program} ${tiled} --times ${bad}/none.txt)
set(lost ${CMAKE_COMMAND} -E env LD_PRELOAD=${FAULTS} "FJELL_FAULT=pread,fread ${tiled} EIO ${from}+" ${program} ${tiled} ${usual})
if(host STREQUAL "c_loop")
  must_say("1" "[^\n]*tiled.fjell: cannot be read. check the disk" ${lost})
else()
  must_say("0|1" "tile [0-9]+: the file could not be read there. [^\n]+" ${lost})
endif()

# And what a frame costs is a line.
file(WRITE ${bad}/views.txt "640 360 0.87\n100 1500 100 0.6 -0.2 0.77 0 1 0\n101 1500 100 0.6 -0.2 0.77 0 1 0\n")
must("times" ${display} ${program} ${tiled} --times ${bad}/views.txt)
if(NOT output MATCHES "times of 2 frames, [0-9]+ vertices, mean/median/p99 us: update [0-9.]+/[0-9.]+/[0-9.]+ [a-z]+ [0-9./]+")
  message(FATAL_ERROR "${host} says of its times: ${output}")
endif()
