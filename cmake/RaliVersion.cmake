# RALI_VERSION_TEXT: what `rali --version` prints. A clone with a tag v* states how far it is from it;
# an archive without git states VERSION.
set(RALI_VERSION_TEXT ${PROJECT_VERSION})
find_program(RALI_GIT git)
if(RALI_GIT AND EXISTS ${CMAKE_SOURCE_DIR}/.git)
  execute_process(COMMAND ${RALI_GIT} describe --tags --match "v[0-9]*" --dirty
    WORKING_DIRECTORY ${CMAKE_SOURCE_DIR} OUTPUT_VARIABLE described RESULT_VARIABLE failed
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(failed EQUAL 0)
    string(REGEX REPLACE "^v" "" RALI_VERSION_TEXT "${described}")
  endif()
endif()
