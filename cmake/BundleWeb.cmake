# cmake -D SOURCE=web -D BUILD=build/x/web -P BundleWeb.cmake
# Bundles the scripts of SOURCE with the esbuild that InstallWeb.cmake put into BUILD: BUILD/report.js.
set(ENV{NODE_PATH} ${BUILD}/node_modules)
execute_process(
  COMMAND ${BUILD}/node_modules/.bin/esbuild ${SOURCE}/src/main.js --bundle --minify --format=iife
    --target=es2020 --legal-comments=inline --log-level=warning --outfile=${BUILD}/report.js
  COMMAND_ERROR_IS_FATAL ANY)
