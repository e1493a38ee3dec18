# rali_web(TARGET rali_report BUNDLE report NAMESPACE rali::report::assets FILES style=src/report.css):
# compiles a bundle of scripts (`script`), its licences (`script_licence`) and files of web/ into TARGET.
#
# web/dist holds the bundles, so that a build needs neither npm nor the network. Where web/ holds
# other scripts or packages than web/dist was made from, npm and esbuild bundle them in the build
# folder; `make bundle` (target rali_bundle) then renews web/dist. What is bundled is web/'s business:
# this file names no package. -DRALI_WEB=OFF builds without scripts.
option(RALI_WEB "the scripts of report.html and of the live page in the program" ON)
find_program(RALI_NPM npm)

function(rali_web)
  cmake_parse_arguments(WEB "" "TARGET;BUNDLE;NAMESPACE" "FILES" ${ARGN})
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  set(source ${CMAKE_SOURCE_DIR}/web)
  set(build ${CMAKE_BINARY_DIR}/web)
  set(assets ${build}/${WEB_BUNDLE}_assets.cpp)
  set(embed ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/tools/embed_files.py)
  set(keep ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/tools/web_bundle.py)
  file(GLOB_RECURSE scripts CONFIGURE_DEPENDS ${source}/src/*.js)
  if(RALI_NPM AND NOT TARGET rali_bundle)
    rali_web_bundle(${source} ${build} "${scripts}")
    add_custom_target(rali_bundle COMMAND ${keep} pack ${source} ${build}
      DEPENDS ${build}/report.js ${build}/live.js COMMENT "Writing web/dist" VERBATIM)
  endif()
  if(RALI_WEB)
    set_property(DIRECTORY ${CMAKE_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${scripts}
      ${source}/package-lock.json ${source}/dist/sources.sha256)
    execute_process(COMMAND ${keep} fresh ${source} RESULT_VARIABLE stale OUTPUT_QUIET)
    set(script ${source}/dist/${WEB_BUNDLE}.js.gz)
    if(stale AND NOT RALI_NPM)
      message(FATAL_ERROR "web/dist was made from other scripts than web/ holds, and npm is not there "
        "to bundle them. Install it (Debian: apt-get install --no-install-recommends nodejs npm) or "
        "configure with -DRALI_WEB=OFF: reports and the live page then have no drawings.")
    elseif(stale)
      message(STATUS "web/dist is older than web/: npm bundles the scripts (make bundle renews it)")
      set(script ${build}/${WEB_BUNDLE}.js)
    endif()
    set(licence ${source}/licences.txt)
  endif()
  set(arguments script=${script} script_licence=${licence})
  foreach(file ${WEB_FILES})
    string(REPLACE "=" "=${source}/" argument ${file})
    list(APPEND arguments ${argument})
    string(REGEX REPLACE "^.*=" "" path ${argument})
    list(APPEND files ${path})
  endforeach()
  add_custom_command(OUTPUT ${assets}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${build}
    COMMAND ${embed} ${assets} ${WEB_NAMESPACE} ${arguments}
    DEPENDS ${script} ${licence} ${files} ${CMAKE_SOURCE_DIR}/tools/embed_files.py
    COMMENT "Embedding the scripts of the ${WEB_BUNDLE} page" VERBATIM)
  target_sources(${WEB_TARGET} PRIVATE ${assets})
  # Literals longer than the standard asks for are no fault here.
  set_source_files_properties(${assets} PROPERTIES COMPILE_OPTIONS
    "-Wno-overlength-strings;-O0" SKIP_PRECOMPILE_HEADERS ON)
endfunction()

# The rule that makes <build>/report.js and live.js. npm runs once per build folder and lock file.
function(rali_web_bundle source build scripts)
  set(installed ${build}/installed.stamp)
  add_custom_command(OUTPUT ${installed}
    COMMAND ${CMAKE_COMMAND} -D NPM=${RALI_NPM} -D SOURCE=${source} -D BUILD=${build}
      -P ${CMAKE_SOURCE_DIR}/cmake/InstallWeb.cmake
    DEPENDS ${source}/package.json ${source}/package-lock.json
      ${CMAKE_SOURCE_DIR}/cmake/InstallWeb.cmake
    COMMENT "Fetching the packages of web/package-lock.json (npm, once)" VERBATIM)
  add_custom_command(OUTPUT ${build}/report.js ${build}/live.js
    COMMAND ${CMAKE_COMMAND} -D SOURCE=${source} -D BUILD=${build}
      -P ${CMAKE_SOURCE_DIR}/cmake/BundleWeb.cmake
    DEPENDS ${installed} ${scripts} ${CMAKE_SOURCE_DIR}/cmake/BundleWeb.cmake
    COMMENT "Bundling the scripts of web/" VERBATIM)
endfunction()
