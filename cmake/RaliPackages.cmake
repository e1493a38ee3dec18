# `make deb`: one package of Debian per component.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME rali)
set(CPACK_PACKAGE_VENDOR RaLI)
set(CPACK_PACKAGE_CONTACT "RaLI maintainers <maintainers@rali.dev>")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ
  GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL ${rali_components})
set(CPACK_COMPONENTS_GROUPING IGNORE)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME rali)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS fonts-dejavu-core)  # rali picture
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "maps with several vehicles where LiDAR is degenerate
RaLI maps tunnels, long corridors, mines and buildings from recordings of one
or several ground vehicles with a spinning LiDAR, an IMU and a radio that
measures ranges. It finds in which directions the LiDAR is degenerate, uses
ranges to the other vehicles there, and states the error to be expected.")

# Static archives name no shared library: what a program links with them is listed here.
set(CPACK_DEBIAN_DEV_PACKAGE_NAME librali-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libeigen3-dev, libfmt-dev, libyaml-cpp-dev, libtbb-dev, \
liblz4-dev, libzstd-dev, libsqlite3-dev, libbz2-dev, libdeflate-dev, libssl-dev, libembree-dev, pkg-config")
set(CPACK_COMPONENT_DEV_DESCRIPTION "maps where LiDAR is degenerate: C++ library
Headers and static libraries of RaLI: map recordings, step a vehicle's
LiDAR-inertial odometry by hand, read results, compare them with a ground
truth. With a package file for CMake and examples.")

if(RALI_PYTHON)
  math(EXPR rali_python_next "${Python_VERSION_MINOR} + 1")  # the module fits one Python
endif()
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-rali)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "python3 (>= ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}), \
python3 (<< ${Python_VERSION_MAJOR}.${rali_python_next}), python3-numpy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${CMAKE_SOURCE_DIR}/cmake/python3-rali/postinst
  ${CMAKE_SOURCE_DIR}/cmake/python3-rali/prerm)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-matplotlib")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "maps where LiDAR is degenerate: Python module
The module rali: map recordings, step a vehicle's LiDAR-inertial odometry with
arrays of numpy, read trajectories, maps and ranges as arrays, compare them
with a ground truth.")
include(CPack)
