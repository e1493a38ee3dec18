# What `make install` and `make deb` put where: the program, its manual page, completions and
# documents. Built on demand (target rali_share), so that a build for tests does not wait for it.
include(GNUInstallDirs)

set(share ${CMAKE_BINARY_DIR}/share)
find_program(RALI_GZIP gzip)

string(REPLACE "-" "+" CPACK_PACKAGE_VERSION ${RALI_VERSION_TEXT})  # "-" parts off a revision
configure_file(${CMAKE_SOURCE_DIR}/cmake/debian_changelog.in ${CMAKE_BINARY_DIR}/debian_changelog
  @ONLY)

# Of the program itself; -n keeps the time out of the compressed file.
add_custom_command(OUTPUT ${share}/rali.1.gz ${share}/rali.bash ${share}/rali.fish
    ${share}/CHANGELOG.md.gz ${share}/changelog.gz
  COMMAND ${CMAKE_COMMAND} -E make_directory ${share}
  COMMAND $<TARGET_FILE:rali> help-man > ${share}/rali.1
  COMMAND ${RALI_GZIP} -9nf ${share}/rali.1
  COMMAND $<TARGET_FILE:rali> completion bash > ${share}/rali.bash
  COMMAND $<TARGET_FILE:rali> completion fish > ${share}/rali.fish
  COMMAND ${RALI_GZIP} -9nc ${CMAKE_SOURCE_DIR}/CHANGELOG.md > ${share}/CHANGELOG.md.gz
  COMMAND ${RALI_GZIP} -9nc ${CMAKE_BINARY_DIR}/debian_changelog > ${share}/changelog.gz
  DEPENDS rali ${CMAKE_SOURCE_DIR}/CHANGELOG.md ${CMAKE_BINARY_DIR}/debian_changelog
  COMMENT "Manual page and completions" VERBATIM)
add_custom_target(rali_share DEPENDS ${share}/rali.1.gz)

install(TARGETS rali RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(FILES ${share}/rali.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${share}/rali.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
  RENAME rali)
install(FILES ${share}/rali.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
set(rali_doc ${CMAKE_INSTALL_DATADIR}/doc/rali)
install(FILES ${share}/changelog.gz ${share}/CHANGELOG.md.gz ${CMAKE_SOURCE_DIR}/README.md
  ${CMAKE_SOURCE_DIR}/THIRD_PARTY_NOTICES.md DESTINATION ${rali_doc})
install(FILES ${CMAKE_SOURCE_DIR}/cmake/copyright DESTINATION ${rali_doc})
install(DIRECTORY ${CMAKE_SOURCE_DIR}/docs/ DESTINATION ${rali_doc}/docs)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME rali)
set(CPACK_PACKAGE_VENDOR RaLI)
set(CPACK_PACKAGE_CONTACT "RaLI maintainers <maintainers@rali.dev>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "maps with several vehicles where LiDAR is degenerate")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "\
RaLI maps tunnels, long corridors, mines and buildings from recordings of one
or several ground vehicles with a spinning LiDAR, an IMU and a radio that
measures ranges. It finds in which directions the LiDAR is degenerate, uses
ranges to the other vehicles there, and states the error to be expected.")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS fonts-dejavu-core)  # rali picture
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ
  GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_STRIP_FILES ON)
include(CPack)
