# must(WHAT COMMAND...): runs it; sets `output`, or fails with what it said.
function(must what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(code)
    string(LENGTH "${output}" length)
    if(length GREATER 4000) # what matters comes last
      math(EXPR from "${length} - 4000")
      string(SUBSTRING "${output}" ${from} -1 output)
    endif()
    message(FATAL_ERROR "${what} failed (${code}):\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

# must_fail(WHAT TEXT COMMAND...): it fails and says TEXT, a regular expression.
function(must_fail what text)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " output "${output}") # CMake breaks its messages into lines
  if(code EQUAL 0 OR NOT output MATCHES "${text}")
    message(FATAL_ERROR "${what}: expected a failure that says \"${text}\", got (${code}):\n${output}")
  endif()
endfunction()

# full_rounds_only(WHAT): in brief rounds, says so and ends the script.
macro(full_rounds_only what)
  if(NOT "$ENV{FJELL_TEST_ROUNDS}" STREQUAL "full")
    message(STATUS "skipped: ${what} (FJELL_TEST_ROUNDS=full does it)")
    return()
  endif()
endmacro()
