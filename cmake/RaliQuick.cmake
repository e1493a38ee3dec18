# What makes a full build quick: several sources of a room in one compiler call (RALI_UNITY), and
# precompiled headers (RALI_PCH). Neither changes a result: each file is compiled with the same
# options. On where everything is built (presets release, asan, tsan, fuzz); off in dev and coverage,
# where a file shows that it includes what it uses, and a changed file is compiled without its
# neighbours.
option(RALI_UNITY "compile several sources of a room at once" OFF)
option(RALI_PCH "precompiled headers of Eigen, fmt and the standard library" OFF)
set(RALI_UNITY_FILES 8 CACHE STRING "most sources in one compiler call; fewer need less memory")

# Without errno a square root is one instruction, and loops with roots are vectorised.
set(RALI_HOT_OPTIONS -O3 -fno-math-errno)

# rali_unity_sources(NAME odometry SOURCES a.cpp... APART b.cpp... OUT variable): what to compile in
# place of SOURCES. The room's own .cpp stay as they are; tools/unity_batches.py chooses which of them
# can share a call.
function(rali_unity_sources)
  cmake_parse_arguments(UNITY "" "NAME;OUT" "SOURCES;APART" ${ARGN})
  set(out ${UNITY_SOURCES})
  if(RALI_UNITY)
    find_package(Python3 REQUIRED COMPONENTS Interpreter)
    set(together ${UNITY_SOURCES})
    list(REMOVE_ITEM together ${UNITY_APART})
    execute_process(
      COMMAND ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/tools/unity_batches.py
        ${CMAKE_BINARY_DIR}/unity/${UNITY_NAME} ${RALI_UNITY_FILES}
        ${CMAKE_SOURCE_DIR}/src ${together}
      OUTPUT_VARIABLE out OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    string(REPLACE "\n" ";" out "${out}")
    foreach(source ${UNITY_APART})
      if(source IN_LIST UNITY_SOURCES)
        list(APPEND out ${source})
      endif()
    endforeach()
  endif()
  set(${UNITY_OUT} ${out} PARENT_SCOPE)
endfunction()

# A precompiled header holds for one set of compiler options only: one for the rooms with hot loops,
# one for all others.
function(rali_make_room_header name)
  file(WRITE ${CMAKE_BINARY_DIR}/${name}.cpp "")
  add_library(${name} STATIC ${CMAKE_BINARY_DIR}/${name}.cpp)
  target_compile_options(${name} PRIVATE ${ARGN})
  target_link_libraries(${name} PRIVATE rali_flags Eigen3::Eigen fmt::fmt)
  target_precompile_headers(${name} PRIVATE <algorithm> <array> <cmath> <cstdint> <deque>
    <functional> <limits> <map> <memory> <numbers> <numeric> <optional> <set> <span> <string>
    <string_view> <tuple> <unordered_map> <utility> <variant> <vector> <Eigen/Dense> <fmt/format.h>
    <tl/expected.hpp> ${CMAKE_SOURCE_DIR}/src/rali/geometry/eigen_instances.hpp)
endfunction()

function(rali_room_header target hot)
  if(NOT RALI_PCH)
    return()
  endif()
  if(NOT TARGET rali_room_header)
    rali_make_room_header(rali_room_header)
    rali_make_room_header(rali_hot_header ${RALI_HOT_OPTIONS})
  endif()
  if(hot)
    target_precompile_headers(${target} REUSE_FROM rali_hot_header)
  else()
    target_precompile_headers(${target} REUSE_FROM rali_room_header)
  endif()
endfunction()
