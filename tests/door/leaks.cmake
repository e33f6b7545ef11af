# No host leaks: it is linked once more with LeakSanitizer, runs, and ends as without. Of door.cmake, behind bad_input.cmake,
# which says what a host is given. What the driver of Vulkan's software renderer leaks is left out by its name; the
# other drivers leak nothing as long as they stay loaded, so that what they still point to can be told from a leak.
file(WRITE ${bad}/keep.cpp "extern \"C\" int dlclose(void*) { return 0; }\n")
must("keeping libraries" ${COMPILER} -shared -fPIC ${bad}/keep.cpp -o ${bad}/keep.so)
file(WRITE ${bad}/leaks.txt "leak:libvulkan_lvp.so\n")
must("configuring with LeakSanitizer" ${CMAKE_COMMAND} -DCMAKE_EXE_LINKER_FLAGS=-fsanitize=leak ${FOLDER})
must("linking with LeakSanitizer" ${CMAKE_COMMAND} --build ${FOLDER} -j 2)
execute_process(COMMAND ${display} ${CMAKE_COMMAND} -E env LD_PRELOAD=${bad}/keep.so
  "LSAN_OPTIONS=suppressions=${bad}/leaks.txt:print_suppressions=0" ${program} ${PACK} ${usual}
  RESULT_VARIABLE ended OUTPUT_VARIABLE output ERROR_VARIABLE errors TIMEOUT 300)
if(ended OR errors MATCHES "LeakSanitizer")
  message(FATAL_ERROR "${host} ends with ${ended} under LeakSanitizer and says ${output}${errors}")
endif()
must("configuring" ${CMAKE_COMMAND} -DCMAKE_EXE_LINKER_FLAGS= ${FOLDER})
must("linking" ${CMAKE_COMMAND} --build ${FOLDER} -j 2)
