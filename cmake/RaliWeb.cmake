# rali_web(TARGET rali_report): bundles web/ (uPlot, three.js and our scripts) with npm and esbuild and
# compiles the result into TARGET. npm runs once per build folder and lock file; the bundle is made
# again only when a script changes. -DRALI_WEB=OFF builds without: reports then have no drawings.
option(RALI_WEB "bundle the scripts of report.html (needs npm and, once, the network)" ON)

function(rali_web)
  cmake_parse_arguments(WEB "" "TARGET" "" ${ARGN})
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  set(source ${CMAKE_SOURCE_DIR}/web)
  set(build ${CMAKE_BINARY_DIR}/web)
  set(assets ${build}/assets.cpp)
  set(embed ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/tools/embed_files.py)
  if(RALI_WEB)
    find_program(RALI_NPM npm)
    if(NOT RALI_NPM)
      message(FATAL_ERROR "npm is needed to bundle the scripts of report.html. "
        "Install it (Debian: apt-get install --no-install-recommends npm) or configure with -DRALI_WEB=OFF.")
    endif()
    set(installed ${build}/installed.stamp)
    add_custom_command(OUTPUT ${installed}
      COMMAND ${CMAKE_COMMAND} -D NPM=${RALI_NPM} -D SOURCE=${source} -D BUILD=${build}
        -P ${CMAKE_SOURCE_DIR}/cmake/InstallWeb.cmake
      DEPENDS ${source}/package.json ${source}/package-lock.json
        ${CMAKE_SOURCE_DIR}/cmake/InstallWeb.cmake
      COMMENT "Fetching uPlot, three.js and esbuild (npm, once)" VERBATIM)
    file(GLOB scripts CONFIGURE_DEPENDS ${source}/src/*.js)
    add_custom_command(OUTPUT ${build}/report.js
      COMMAND ${CMAKE_COMMAND} -E env NODE_PATH=${build}/node_modules
        ${build}/node_modules/.bin/esbuild ${source}/src/main.js --bundle --minify --format=iife
        --target=es2020 --legal-comments=inline --log-level=warning --outfile=${build}/report.js
      DEPENDS ${installed} ${scripts}
      COMMENT "Bundling the scripts of report.html" VERBATIM)
    set(script ${build}/report.js)
    set(licence ${CMAKE_SOURCE_DIR}/THIRD_PARTY_NOTICES.md)
  endif()
  add_custom_command(OUTPUT ${assets}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${build}
    COMMAND ${embed} ${assets} rali::report::assets script=${script} style=${source}/src/report.css
      script_licence=${licence}
    DEPENDS ${script} ${licence} ${source}/src/report.css ${CMAKE_SOURCE_DIR}/tools/embed_files.py
    COMMENT "Embedding the scripts of report.html" VERBATIM)
  target_sources(${WEB_TARGET} PRIVATE ${assets})
  # Literals longer than the standard asks for are no fault here.
  set_source_files_properties(${assets} PROPERTIES COMPILE_OPTIONS
    "-Wno-overlength-strings;-O0")
endfunction()
