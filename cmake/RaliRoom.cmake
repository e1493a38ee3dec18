# rali_room(NAME odometry DEPS geometry sensor [LIBS external...] [HOT])
#
# A room is one folder src/rali/<name> = one static library rali_<name> (alias rali::<name>) and,
# where it has *_test.cpp files, one test program. DEPS are the rooms it may include; they are
# compared with tools/layers.txt by tools/check_layers.py.
if(RALI_TESTS)
  find_package(GTest REQUIRED)
  include(GoogleTest)
endif()

function(rali_room)
  cmake_parse_arguments(ROOM "HOT" "NAME" "DEPS;LIBS" ${ARGN})
  set(dir ${CMAKE_SOURCE_DIR}/src/rali/${ROOM_NAME})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${dir}/*.cpp)
  set(tests ${sources})
  list(FILTER sources EXCLUDE REGEX "_test\\.cpp$|/main\\.cpp$")
  list(FILTER tests INCLUDE REGEX "_test\\.cpp$")

  if(sources)
    add_library(rali_${ROOM_NAME} STATIC ${sources})
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

  if(ROOM_HOT AND sources AND CMAKE_BUILD_TYPE STREQUAL "Release")
    # Without errno a square root is one instruction, and loops with roots are vectorised.
    target_compile_options(rali_${ROOM_NAME} PRIVATE -O3 -fno-math-errno)
  endif()

  if(RALI_TESTS AND tests)
    add_executable(rali_${ROOM_NAME}_test ${tests})
    target_link_libraries(rali_${ROOM_NAME}_test PRIVATE rali_${ROOM_NAME} GTest::gtest_main)
    target_compile_definitions(rali_${ROOM_NAME}_test PRIVATE
      RALI_SOURCE_DIR="${CMAKE_SOURCE_DIR}" RALI_DATA_DIR="${CMAKE_SOURCE_DIR}/../shared/data")
    gtest_discover_tests(rali_${ROOM_NAME}_test TEST_PREFIX "${ROOM_NAME}." DISCOVERY_TIMEOUT 60
      PROPERTIES TIMEOUT 300)
  endif()
endfunction()
