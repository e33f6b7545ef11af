# What content/hosts/vulkan does once it is built: what it prints, what it refuses, and that it notices mistakes. Of
# door.cmake.
set(host ${FOLDER}/vulkan)
if(NOT EXISTS ${host})
  message(FATAL_ERROR "the host was left out: ${output}")
endif()
set(tiled ${FOLDER}/tiled.fjell) # 64 tiles, so that some are not seen
must("baking" ${BAKE} ${RECIPE} --tile 64 -o ${tiled} --quiet)
set(picture ${FOLDER}/picture.ppm)
# With its checks of synchronisation, from frame to frame too.
set(listening ${CMAKE_COMMAND} -E env VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation
  VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT:VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_SUBMIT)

# numbers(PATTERN...): `output` is these lines; sets n1, n2, ... to what they capture.
function(numbers)
  list(JOIN ARGN "\n" pattern)
  if(NOT output MATCHES "^${pattern}\n$")
    message(FATAL_ERROR "the host with Vulkan says: ${output}")
  endif()
  foreach(i RANGE 1 9)
    set(n${i} ${CMAKE_MATCH_${i}} PARENT_SCOPE)
  endforeach()
endfunction()
function(between what value least most)
  if(value LESS least OR value GREATER most)
    message(FATAL_ERROR "${what}: ${value}, not ${least} to ${most}: ${output}")
  endif()
endfunction()
function(must_end code text)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE ended OUTPUT_VARIABLE output ERROR_VARIABLE errors TIMEOUT 120)
  if(NOT ended EQUAL code OR NOT errors MATCHES "^(vulkan: [^\n]*\n)*vulkan: ${text}\n")
    message(FATAL_ERROR "the host with Vulkan ends with ${ended} and says ${output}${errors}where ${code} and \"${text}\" are expected")
  endif()
endfunction()

set(count "([0-9]+)")
set(any "[-0-9.e]+")
set(device "on [^\n]+")
set(eye "eye (${any},${any},${any}) looks at (${any},${any},${any})")
set(compared "${count} vertices compared, ${count} of them half-way. rounding moves them by ([0-9.]+) px and [0-9.]+ m at most"
  "${count} pixels compared with the full resolution, off by [0-9.]+ px at most, ${count}% of what is allowed")
set(cost "update ${any} us, staging ${any} us, recording ${any} us, submitting ${any} us \\(medians\\)")

# The flight, and the layer that listens.
must("flying" ${listening} ${host} ${tiled} ${picture} 240)
numbers(${device} "eye [^\n]+" "converged 1: [0-9]+ vertices, [0-9]+ triangles, ${count} of 64 tiles drawn in [0-9]+ ranges. rebased ${count} times"
  "16 bytes a vertex for 28, 2 an index. [0-9.]+ MB on the device" "copies of a vertex if each range had its own: [0-9.]+, each tile: [0-9.]+" "uploaded ${count} bytes a frame \\(median\\), exactly what had changed"
  ${compared} "${cost}. [0-9]+ allocations" "0 messages of Vulkan's validation")
between("tiles drawn" ${n1} 8 56)
between("moves of the origin" ${n2} 2 10)
between("bytes uploaded a frame" ${n3} 1 20000)
between("vertices compared" ${n4} 100000 1000000)
between("vertices half-way" ${n5} 5000 1000000)
between("rounding [px]" ${n6} 0.0005 0.0063) # fjell::compact_share(): (1/2048)/(1 - 1/1.05^2) + 1/1024 at 1 px
between("pixels compared" ${n7} 30000 60000)
between("share of what is allowed" ${n8} 30 100) # a bound that nothing comes near would notice nothing

# Without the layer, which allocates: a frame does not. And the mesh is that of fjell-fly, and so is the skyline.
must("flying" ${host} ${tiled} ${picture} 120)
numbers(${device} ${eye} "converged 1: [0-9]+ vertices, ${count} triangles, [^\n]+" "16 bytes[^\n]+" "copies[^\n]+" "uploaded[^\n]+" "[^\n]+ compared, [^\n]+"
  "[^\n]+ compared with [^\n]+" "${cost}. 0 allocations" "0 messages of Vulkan's validation")
set(triangles ${n3})
must("fjell-fly" ${FLY} ${tiled} --headless --frames 1 --size 640x360 --fov 57.29577951308232 --error-px 1 --morph error
  --eye ${n1} --look ${n2} --mode distance --samples 1 --render ${FOLDER} --json ${FOLDER}/fly.json)
file(READ ${FOLDER}/fly.json json)
string(JSON expected GET "${json}" triangles_mean)
if(NOT expected EQUAL triangles)
  message(FATAL_ERROR "the host with Vulkan has ${triangles} triangles, fjell-fly ${expected}")
endif()
must("converting" gdal_translate -q -of PNM ${FOLDER}/frame_00000.png ${FOLDER}/fly.ppm)
function(skyline file colour out) # S where a pixel is sky, a dot elsewhere
  file(READ ${file} hex OFFSET 15 HEX) # behind "P6\n640 360\n255\n"
  string(REGEX REPLACE "(......)" "\\1," hex "${hex}")
  string(REPLACE "${colour}," "S" hex "${hex}")
  string(REGEX REPLACE "[0-9a-f]+," "." hex "${hex}")
  set(${out} "${hex}" PARENT_SCOPE)
endfunction()
skyline(${picture} 597eb1 ours) # as the host clears it
skyline(${FOLDER}/fly.ppm 000000 theirs)
string(REPLACE "." "" sky "${ours}")
string(LENGTH "${sky}" sky)
between("pixels of sky" ${sky} 23040 115200)
set(apart 0)
foreach(y RANGE 359)
  math(EXPR row "640 * ${y}")
  string(SUBSTRING "${ours}" ${row} 640 our_row)
  string(SUBSTRING "${theirs}" ${row} 640 their_row)
  if(our_row STREQUAL their_row)
    continue()
  endif()
  foreach(x RANGE 639)
    string(SUBSTRING "${our_row}" ${x} 1 our_pixel)
    string(SUBSTRING "${their_row}" ${x} 1 their_pixel)
    if(NOT our_pixel STREQUAL their_pixel)
      math(EXPR apart "${apart} + 1")
    endif()
  endforeach()
endforeach()
between("pixels that are sky in one picture only" ${apart} 0 23) # of 230,400: skylines, where a rounding shows

# More vertices than 16 bits name; too few; too few pages; a disk that fails: coarser, and within what is reported.
must("flying" ${listening} ${host} ${tiled} ${picture} 30 65537)
numbers(${device} "eye [^\n]+" "converged 1: [^\n]+" "16 bytes a vertex for 28, 4 an index. [^\n]+" "copies[^\n]+" "uploaded[^\n]+" "[^\n]+ compared, [^\n]+"
  "[^\n]+ compared with [^\n]+" "${cost}. [0-9]+ allocations" "0 messages of Vulkan's validation")
must_end(0 "raise CutBudget::(vertices|triangles)" ${host} ${tiled} ${picture} 60 18000)
must_end(0 "raise TerrainBudget::page_slots" ${host} ${tiled} ${picture} 60 65536 100)
must_end(0 "tile [0-9]+: the file could not be read there. .*" ${CMAKE_COMMAND} -E env LD_PRELOAD=${FAULTS}
  "FJELL_FAULT=pread ${PACK} EIO 30+" ${host} ${PACK} ${picture} 60)

# Columns that 16 bits do not hold.
must("heights" ${BAKE} synth ${RECIPE} -o ${FOLDER}/small.tif)
must("widening" gdal_translate -q -outsize 70000 65 -r bilinear ${FOLDER}/small.tif ${FOLDER}/wide.tif)
must("baking" ${BAKE} ${FOLDER}/wide.tif -o ${FOLDER}/wide.fjell --spacing 60 --tile 256 --quiet)
must("flying" ${host} ${FOLDER}/wide.fjell ${picture} 30 100000 8000)
if(NOT output MATCHES "2[0-9][0-9] of 274 tiles drawn")
  message(FATAL_ERROR "the host with Vulkan says: ${output}")
endif()

# What is wrong is one sentence.
must_end(2 "usage: vulkan PACK PICTURE.ppm .*" ${host})
must_end(2 "FRAMES, VERTICES and PAGES are whole numbers from 1 on" ${host} ${tiled} ${picture} 10 -5)
must_end(1 "[^\n]*none.fjell: [^\n]+" ${host} ${FOLDER}/none.fjell ${picture})
must_end(1 "[^\n]*picture.ppm: magic: this is not a Fjell pack. bake the height field with fjell-bake first[^\n]*" ${host} ${picture} ${picture})
must_end(1 "[^\n]+: CutBudget::vertices \\(4 a tile\\): the budget cannot hold the coarsest mesh. raise the field" ${host} ${tiled} ${picture} 1 3)
must_end(3 "[^\n]*/none/picture.ppm: cannot be written. give a place with room" ${host} ${tiled} ${FOLDER}/none/picture.ppm 1)
must_end(3 "no device of Vulkan 1.3 that draws indirectly. install a driver for the GPU, or one that needs none \\(mesa-vulkan-drivers\\)"
  ${CMAKE_COMMAND} -E env VK_DRIVER_FILES=/none VK_ICD_FILENAMES=/none ${host} ${tiled} ${picture})
must("another version" bash -c "cp '${tiled}' '${FOLDER}/old.fjell' && printf '\\003' | dd of='${FOLDER}/old.fjell' bs=1 seek=8 conv=notrunc status=none")
must_end(1 "[^\n]*version: the pack was written by another version of fjell-bake. bake it again with this one[^\n]*" ${host} ${FOLDER}/old.fjell ${picture})

# A mistake is compiled into the host, and its own checks or the layer must find it.
function(must_notice plant text)
  must("planting ${plant}" ${CMAKE_COMMAND} -DPLANT=PLANT_${plant} ${FOLDER})
  must("building with ${plant}" ${CMAKE_COMMAND} --build ${FOLDER} -j 2)
  must_end(1 "${text}" ${listening} ${host} ${tiled} ${picture} 120)
endfunction()
must_notice(ROUNDED_DOWN "a vertex is drawn -[0-9.]+ m nearer to its full height than morphed_height_m\\(\\) says, .*")
must_notice(FORGOTTEN_RUN "vertex slot [0-9]+ is not on the device as it is in the cut")
must_notice(NO_BARRIER "Validation Error: \\[ SYNC-HAZARD-WRITE-AFTER-READ \\] .*")
must("planting NO_ROOM" ${CMAKE_COMMAND} -DPLANT=PLANT_NO_ROOM ${FOLDER})
must("building with NO_ROOM" ${CMAKE_COMMAND} --build ${FOLDER} -j 2)
must("flying" ${host} ${tiled} ${picture} 60)
if(NOT output MATCHES "[1-9][0-9]* allocations\n")
  message(FATAL_ERROR "nobody notices that frames allocate: ${output}")
endif()
