# The installed library: the objects of the rooms in two archives, so that users meet the targets
# rali::core and rali::io and no room. Included where the rooms are,
# since the packages that they need are known there alone.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# rali_archive(core ROOMS base ... LIBS Eigen3::Eigen ...)
function(rali_archive name)
  cmake_parse_arguments(ARCHIVE "" "" "ROOMS;LIBS" ${ARGN})
  foreach(room ${ARCHIVE_ROOMS})
    # closed_loop runs the simulator, which a library of recordings does not need.
    list(APPEND objects $<FILTER:$<TARGET_OBJECTS:rali_${room}>,EXCLUDE,/closed_loop/>)
  endforeach()
  add_library(rali_library_${name} STATIC ${objects})
  set_target_properties(rali_library_${name} PROPERTIES
    OUTPUT_NAME rali_${name} EXPORT_NAME ${name} LINKER_LANGUAGE CXX
    ARCHIVE_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/library)
  target_include_directories(rali_library_${name} INTERFACE
    $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(rali_library_${name} INTERFACE cxx_std_20)
  target_link_libraries(rali_library_${name} INTERFACE ${ARCHIVE_LIBS})
  install(TARGETS rali_library_${name} EXPORT rali_${name} COMPONENT dev
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(EXPORT rali_${name} NAMESPACE rali:: FILE rali-${name}.cmake COMPONENT dev
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/rali)
endfunction()

rali_archive(core ROOMS ${RALI_CORE_ROOMS} LIBS Eigen3::Eigen fmt::fmt)
rali_archive(io ROOMS ${RALI_IO_ROOMS} LIBS rali_library_core yaml-cpp TBB::tbb PkgConfig::LZ4
  PkgConfig::ZSTD PkgConfig::SQLITE3 PkgConfig::DEFLATE PkgConfig::CRYPTO BZip2::BZip2 embree)

configure_package_config_file(${CMAKE_SOURCE_DIR}/cmake/raliConfig.cmake.in
  ${CMAKE_BINARY_DIR}/library/raliConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/rali)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/library/raliConfigVersion.cmake
  VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/library/raliConfig.cmake
  ${CMAKE_BINARY_DIR}/library/raliConfigVersion.cmake COMPONENT dev
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/rali)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/include/rali COMPONENT dev
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.hpp")
install(DIRECTORY ${CMAKE_SOURCE_DIR}/examples COMPONENT dev
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/librali-dev FILES_MATCHING PATTERN "*.cpp"
  PATTERN "CMakeLists.txt")
