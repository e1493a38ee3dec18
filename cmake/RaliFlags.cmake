# One target carries every compile flag, so that all rooms are built alike.
# No flag here may change a result: -ffp-contract=off keeps a*b+c two roundings on every machine,
# and -ffast-math never appears.
add_library(rali_flags INTERFACE)
target_include_directories(rali_flags INTERFACE ${CMAKE_SOURCE_DIR}/src)
target_compile_options(rali_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wdouble-promotion -ffp-contract=off)
target_compile_definitions(rali_flags INTERFACE EIGEN_MPL2_ONLY EIGEN_DONT_PARALLELIZE)
if(RALI_WERROR)
  target_compile_options(rali_flags INTERFACE -Werror)
endif()

set(CMAKE_CXX_FLAGS_RELEASE "-O2")  # rooms with hot loops add -O3 (rali_room HOT)
# False alarms of g++ 12 in inlined library code of optimised or instrumented builds.
set(rali_false_alarms "$<CONFIG:Release>")
if(RALI_SANITIZE)
  set(rali_false_alarms 1)
endif()
target_compile_options(rali_flags INTERFACE
  "$<$<AND:$<CXX_COMPILER_ID:GNU>,${rali_false_alarms}>:-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread;-Wno-maybe-uninitialized;-Wno-restrict>")
set(CMAKE_CXX_FLAGS_DEV "-O1 -g1")
if(CMAKE_BUILD_TYPE STREQUAL "Dev")
  target_compile_definitions(rali_flags INTERFACE _GLIBCXX_ASSERTIONS RALI_DEBUG_CHECKS=1)
else()
  target_compile_definitions(rali_flags INTERFACE NDEBUG)
endif()

set(RALI_SANITIZE "" CACHE STRING "comma separated list for -fsanitize=")
if(RALI_SANITIZE)
  target_compile_options(rali_flags INTERFACE -fsanitize=${RALI_SANITIZE} -fno-omit-frame-pointer
    -fno-sanitize-recover=all)
  target_link_options(rali_flags INTERFACE -fsanitize=${RALI_SANITIZE})
endif()
option(RALI_COVERAGE "instrument for gcov" OFF)
if(RALI_COVERAGE)
  target_compile_options(rali_flags INTERFACE --coverage)
  target_link_options(rali_flags INTERFACE --coverage)
endif()

find_program(RALI_CCACHE ccache)
if(RALI_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${RALI_CCACHE})
endif()
