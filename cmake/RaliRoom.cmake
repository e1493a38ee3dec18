# rali_room(NAME odometry DEPS geometry sensor [LIBS external...] [APART file.cpp...] [HOT])
#
# A room is one folder src/rali/<name> = one static library rali_<name> (alias rali::<name>) and,
# where it has *_test.cpp files, one test program. DEPS are the rooms it may include; they are
# compared with tools/layers.txt by tools/check_layers.py. APART: files with properties of their own,
# which no other file shares a compiler call with.
include(RaliQuick)

if(RALI_TESTS)
  find_package(GTest REQUIRED)
  include(GoogleTest)
  if(RALI_PCH AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    file(WRITE ${CMAKE_BINARY_DIR}/test_header.cpp "")
    add_library(rali_test_header STATIC ${CMAKE_BINARY_DIR}/test_header.cpp)
    target_compile_options(rali_test_header PRIVATE -O1)
    target_compile_definitions(rali_test_header PRIVATE
      RALI_SOURCE_DIR="${CMAKE_SOURCE_DIR}" RALI_DATA_DIR="${CMAKE_SOURCE_DIR}/../shared/data")
    target_link_libraries(rali_test_header PRIVATE rali_flags GTest::gtest)
    target_precompile_headers(rali_test_header PRIVATE <algorithm> <cmath> <functional> <map>
      <memory> <optional> <string> <variant> <vector> <gtest/gtest.h>)
  endif()
endif()

# Most of a build's time is tests, and most of a test's time is gtest and the standard library: one
# precompiled header for all of them (RALI_PCH, gcc), and light optimisation of what only tests run.
function(rali_quick_test_build target)
  if(NOT RALI_PCH OR NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    return()
  endif()
  target_compile_options(${target} PRIVATE -O1)
  if(TARGET rali_test_header)
    target_precompile_headers(${target} REUSE_FROM rali_test_header)
  endif()
endfunction()

function(rali_room)
  cmake_parse_arguments(ROOM "HOT" "NAME" "DEPS;LIBS;APART" ${ARGN})
  if(NOT CMAKE_BUILD_TYPE STREQUAL "Release")
    set(ROOM_HOT FALSE)
  endif()
  set(dir ${CMAKE_SOURCE_DIR}/src/rali/${ROOM_NAME})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${dir}/*.cpp)
  if(NOT RALI_PCH)  # only what includes the precompiled header uses them
    list(FILTER sources EXCLUDE REGEX "/eigen_instances\\.cpp$")
  endif()
  set(tests ${sources})
  list(FILTER sources EXCLUDE REGEX "_test\\.cpp$|/main\\.cpp$")
  list(FILTER tests INCLUDE REGEX "_test\\.cpp$")

  if(sources)
    list(TRANSFORM ROOM_APART PREPEND ${dir}/)
    rali_unity_sources(NAME ${ROOM_NAME} SOURCES ${sources} APART ${ROOM_APART} OUT compiled)
    add_library(rali_${ROOM_NAME} STATIC ${compiled})
    set(scope PUBLIC)
  else()
    add_library(rali_${ROOM_NAME} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(rali::${ROOM_NAME} ALIAS rali_${ROOM_NAME})
  target_link_libraries(rali_${ROOM_NAME} ${scope} rali_flags)
  foreach(dep ${ROOM_DEPS})
    target_link_libraries(rali_${ROOM_NAME} ${scope} rali_${dep})
  endforeach()
  target_link_libraries(rali_${ROOM_NAME} ${scope} ${ROOM_LIBS})

  if(ROOM_HOT AND sources)
    target_compile_options(rali_${ROOM_NAME} PRIVATE ${RALI_HOT_OPTIONS})
  endif()
  if(sources)
    if(RALI_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      # A .cpp included by a batch is a header to gcc, whose types may not use file-local ones.
      target_compile_options(rali_${ROOM_NAME} PRIVATE -Wno-subobject-linkage)
    endif()
    rali_room_header(rali_${ROOM_NAME} "${ROOM_HOT}")
  endif()

  if(RALI_TESTS AND tests)
    add_executable(rali_${ROOM_NAME}_test ${tests})
    target_link_libraries(rali_${ROOM_NAME}_test PRIVATE rali_${ROOM_NAME} GTest::gtest_main)
    target_compile_definitions(rali_${ROOM_NAME}_test PRIVATE
      RALI_SOURCE_DIR="${CMAKE_SOURCE_DIR}" RALI_DATA_DIR="${CMAKE_SOURCE_DIR}/../shared/data")
    rali_quick_test_build(rali_${ROOM_NAME}_test)
    gtest_discover_tests(rali_${ROOM_NAME}_test TEST_PREFIX "${ROOM_NAME}." DISCOVERY_TIMEOUT 60
      PROPERTIES TIMEOUT 300)
  endif()
endfunction()
