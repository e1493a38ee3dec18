# cmake -D NPM=.. -D SOURCE=web -D BUILD=build/x/web -P InstallWeb.cmake
# Installs exactly what web/package-lock.json names into the build folder; no script of a package is
# run. What npm has in its cache is taken from there.
file(MAKE_DIRECTORY ${BUILD})
foreach(file package.json package-lock.json)
  file(COPY_FILE ${SOURCE}/${file} ${BUILD}/${file})
endforeach()
execute_process(
  COMMAND ${NPM} ci --ignore-scripts --prefer-offline --no-audit --no-fund --loglevel=error
    --fetch-retries=2 --fetch-retry-mintimeout=500
    --fetch-retry-maxtimeout=3000 --fetch-timeout=60000
  WORKING_DIRECTORY ${BUILD} RESULT_VARIABLE code OUTPUT_VARIABLE said ERROR_VARIABLE said)
if(NOT code EQUAL 0)
  file(WRITE ${BUILD}/npm.log "${said}")
  message(FATAL_ERROR "the packages of web/package-lock.json could not be fetched from the npm registry "
    "(see ${BUILD}/npm.log): connect to the network once, or configure with -DRALI_WEB=OFF: reports "
    "then have no drawings.")
endif()
file(TOUCH ${BUILD}/installed.stamp)
