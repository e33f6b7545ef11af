# Puts the npm packages that FOLDER/package-lock.json names into FOLDER; does nothing when they are there already.
find_program(NPM npm)
find_program(NODE node)
if(NOT NPM OR NOT NODE)
  message(FATAL_ERROR "node or npm is missing: tests run packages of npm; "
    "./dev test installs the Debian packages nodejs and npm")
endif()
file(SHA256 ${FOLDER}/package-lock.json wanted)
if(EXISTS ${FOLDER}/node_modules/.fjell)
  file(READ ${FOLDER}/node_modules/.fjell installed)
  if(installed STREQUAL wanted)
    return()
  endif()
endif()
execute_process(COMMAND ${NPM} ci --no-audit --no-fund WORKING_DIRECTORY ${FOLDER}
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "npm ci failed in ${FOLDER}; tests need the packages that are named there, "
    "so check the network:\n${output}")
endif()
file(WRITE ${FOLDER}/node_modules/.fjell ${wanted})
