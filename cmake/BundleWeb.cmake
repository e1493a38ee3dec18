# cmake -D SOURCE=web -D BUILD=build/x/web -P BundleWeb.cmake
# Bundles the scripts of SOURCE with the esbuild that InstallWeb.cmake put into BUILD: BUILD/report.js
# and BUILD/live.js.
set(ENV{NODE_PATH} ${BUILD}/node_modules)
foreach(bundle report=main.js live=live/main.js)
  string(REGEX MATCH "^([a-z]+)=(.*)$" matched ${bundle})
  execute_process(
    COMMAND ${BUILD}/node_modules/.bin/esbuild ${SOURCE}/src/${CMAKE_MATCH_2} --bundle --minify
      --format=iife --target=es2020 --legal-comments=inline --log-level=warning
      --outfile=${BUILD}/${CMAKE_MATCH_1}.js
    COMMAND_ERROR_IS_FATAL ANY)
endforeach()
