# What content/hosts/physics and content/hosts/server do once they are built: what they print, what they refuse, and
# that they notice when their ground is wrong. Of door.cmake.
get_filename_component(host ${HOST} NAME)

# numbers(PATTERN...): `output` is these lines; sets n1, n2, ... to what they capture. A semicolon would end a pattern: a dot.
function(numbers)
  set(pattern "^")
  foreach(line ${ARGN})
    string(APPEND pattern "${line}\n")
  endforeach()
  if(NOT output MATCHES "${pattern}$")
    message(FATAL_ERROR "${host} says: ${output}")
  endif()
  foreach(i RANGE 1 9)
    set(n${i} ${CMAKE_MATCH_${i}} PARENT_SCOPE)
  endforeach()
endfunction()
function(at_least what value least)
  if(value LESS least)
    message(FATAL_ERROR "${host}: ${what}: ${value}, not ${least} or more: ${output}")
  endif()
endfunction()

# must_end(CODE TEXT ARGUMENTS...): it ends with that code and a line that matches TEXT on its standard error.
function(must_end code text)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE ended OUTPUT_VARIABLE output ERROR_VARIABLE errors TIMEOUT 120)
  if(NOT ended EQUAL code OR NOT errors MATCHES "^${host}: ${text}\n")
    message(FATAL_ERROR "${host} ends with ${ended} and says ${output}${errors}where ${code} and \"${text}\" are expected")
  endif()
endfunction()

# A mistake is compiled into the host's ground, and its own checks must find it.
function(must_notice plant text)
  must("planting ${plant}" ${CMAKE_COMMAND} -DPLANT=PLANT_${plant} ${FOLDER})
  must("building with ${plant}" ${CMAKE_COMMAND} --build ${FOLDER} -j 2)
  must_end(1 "${text}" ${FOLDER}/${host} ${PACK})
endfunction()

if(host STREQUAL "physics")
  must("rolling for a minute" ${FOLDER}/physics ${PACK} 60 160)
  numbers("200 bodies rolled ([0-9]+) m on average. ([0-9]+) fell through holes, 0 were never placed, held for ([0-9]+) steps"
    "([0-9]+) contacts, off by ([0-9]+)% of what is allowed at most. no body under the ground"
    "patches: ([0-9]+) made, ([0-9]+) made again, ([0-9]+) dropped. [0-9.]+ us each from loaded pages \\(median\\)"
    "pages: [0-9]+ came, ([0-9]+) went, room for 160 of 704")
  at_least("metres rolled" ${n1} 100)
  at_least("bodies through holes" ${n2} 3)
  at_least("steps held" ${n3} 1000)
  at_least("contacts" ${n4} 500000)
  at_least("share of what is allowed" ${n5} 30) # a bound that nothing comes near would notice nothing
  at_least("patches" ${n6} 40)
  at_least("patches made again" ${n7} 20)
  at_least("patches dropped" ${n8} 20)
  at_least("pages evicted" ${n9} 20)
  # The same figures once more, but for the time.
  foreach(run first second)
    must("rolling" ${FOLDER}/physics ${PACK} 2)
    string(REGEX REPLACE "[0-9.]+ us" "" ${run} "${output}")
  endforeach()
  if(NOT first STREQUAL second)
    message(FATAL_ERROR "physics does not repeat itself: ${first}and ${second}")
  endif()
  must("digging" ${FOLDER}/physics ${PACK} --dig)
  numbers("a body fell ([0-9]+) mm into a crater of 4000 mm, and rests on its floor. contacts are off by ([0-9]+)% of what is allowed at most. ([0-9]+) patches were read again")
  at_least("millimetres fallen" ${n1} 3200)
  at_least("patches read again" ${n3} 1)
  set(lost 40+) # of the reads of the file
  set(while 2)
else()
  must("serving" ${FOLDER}/server ${PACK} 120)
  numbers("memory: [0-9.]+ MB for 8 terrains of 100 pages. Recast and Detour [0-9.]+ MB at most"
    "pages: ([0-9]+) came, ([0-9]+) went"
    "8 threads: ([0-9.]+) M heights/s and ([0-9.]+) M rays/s a thread, of its processor time"
    "([0-9]+) answers compared, ([0-9]+) of the full resolution. none further off than it said"
    "navigation: ([0-9]+) tiles made, ([0-9]+) made again, [0-9]+ dropped. ([0-9]) of 8 walkers stand on one")
  at_least("pages loaded" ${n1} 400)
  at_least("pages evicted" ${n2} 50)
  at_least("answers compared" ${n5} 50000)
  math(EXPR coarse "${n5} - ${n6}")
  at_least("answers from coarser ground" ${coarse} 1000)
  at_least("tiles" ${n7} 72)
  at_least("tiles made again" ${n8} 5)
  at_least("walkers on the mesh" ${n9} 6)
  must("digging" ${FOLDER}/server ${PACK} --dig)
  numbers("a crater of 28 m touched ([0-9]+) of ([0-9]+) tiles. ([0-9]+) were made again, in [0-9.]+ ms each \\(median\\)")
  at_least("tiles touched" ${n1} 1)
  math(EXPR untouched "${n2} - ${n3}")
  at_least("tiles that stay" ${untouched} 1)
  set(lost 200+)
  set(while 50)
endif()

must_end(2 "usage: ${host} PACK .*" ${FOLDER}/${host})
must_end(2 ".* are whole numbers from 1 on" ${FOLDER}/${host} ${PACK} 1 0)
must_end(3 ".*none.fjell: cannot be opened; give a pack that fjell-bake has written" ${FOLDER}/${host} ${FOLDER}/none.fjell)
must_end(3 "TerrainBudget::page_slots \\(one a tile\\): the budget cannot hold the coarsest mesh; raise the field"
  ${FOLDER}/${host} ${PACK} 1 3)
must("another version" bash -c "cp '${PACK}' '${FOLDER}/old.fjell' && printf '\\003' | dd of='${FOLDER}/old.fjell' bs=1 seek=8 conv=notrunc status=none")
must_end(3 ".*/old.fjell: version: the pack was written by another version of fjell-bake; bake it again with this one: fjell-bake HEIGHTS -o PACK"
  ${FOLDER}/${host} ${FOLDER}/old.fjell)
must_end(0 "tile [0-9]+: the file could not be read there. .*" ${CMAKE_COMMAND} -E env LD_PRELOAD=${FAULTS}
  "FJELL_FAULT=pread ${PACK} EIO ${lost}" ${FOLDER}/${host} ${PACK} ${while})

if(host STREQUAL "physics")
  must_notice(WRONG_DIAGONALS "a contact at x [0-9.]+, z [0-9.]+: [0-9.]+ m off the full-resolution ground, [0-9.]+ m allowed")
  must_notice(CLOSED_HOLES "a contact over a hole at x [0-9.]+, z [0-9.]+")
  must_notice(NOT_HELD "(a contact|a body's centre is under the ground) at x [0-9.]+, z [0-9.]+: .*")
else()
  must_notice(CLOSED_HOLES "the navigation mesh of tile [0-9]+, [0-9]+ is .*, and closes a hole")
endif()
