# RALI_PYTHON: the Python module `rali` (folder python/). ON where pybind11 and the headers of Python
# are found. The rooms of the library are then compiled position independent, since the module is a
# shared library. The Python of the distribution comes first: the package python3-rali is for it.
if(NOT DEFINED Python_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python_EXECUTABLE /usr/bin/python3)
endif()
find_package(Python 3.9 QUIET COMPONENTS Interpreter Development.Module)
find_package(pybind11 2.6 CONFIG QUIET)
set(rali_python_found OFF)
if(Python_Development.Module_FOUND AND pybind11_FOUND)
  set(rali_python_found ON)
endif()
set(rali_python_default ${rali_python_found})
if(RALI_SANITIZE OR RALI_COVERAGE OR RALI_FUZZ)
  set(rali_python_default OFF)  # Python itself is not instrumented
endif()
option(RALI_PYTHON "build the Python module (needs pybind11 and Python's headers)"
  ${rali_python_default})
if(RALI_PYTHON AND NOT rali_python_found)
  message(FATAL_ERROR "The Python module needs pybind11 and the headers of Python. Install them "
    "(Debian: apt-get install pybind11-dev python3-dev) or configure with -DRALI_PYTHON=OFF.")
endif()
