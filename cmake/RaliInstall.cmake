# What `make install` and `make deb` put where. Components: program (with its manual page, completions
# and documents), dev (RaliLibrary.cmake), python (python/CMakeLists.txt).
# `make demo` builds the target rali alone and does without rali_share.
include(GNUInstallDirs)

set(share ${CMAKE_BINARY_DIR}/share)
find_program(RALI_GZIP gzip)

string(REPLACE "-" "+" CPACK_PACKAGE_VERSION ${RALI_VERSION_TEXT})  # "-" parts off a revision
configure_file(${CMAKE_SOURCE_DIR}/cmake/debian_changelog.in ${CMAKE_BINARY_DIR}/debian_changelog
  @ONLY)

# Of the program itself; -n keeps the time out of the compressed file.
add_custom_command(OUTPUT ${share}/rali.1.gz ${share}/rali.bash ${share}/rali.fish
    ${share}/_rali
    ${share}/CHANGELOG.md.gz ${share}/changelog.gz
  COMMAND ${CMAKE_COMMAND} -E make_directory ${share}
  COMMAND $<TARGET_FILE:rali> help-man > ${share}/rali.1
  COMMAND ${RALI_GZIP} -9nf ${share}/rali.1
  COMMAND $<TARGET_FILE:rali> completion bash > ${share}/rali.bash
  COMMAND $<TARGET_FILE:rali> completion fish > ${share}/rali.fish
  COMMAND $<TARGET_FILE:rali> completion zsh > ${share}/_rali
  COMMAND ${RALI_GZIP} -9nc ${CMAKE_SOURCE_DIR}/CHANGELOG.md > ${share}/CHANGELOG.md.gz
  COMMAND ${RALI_GZIP} -9nc ${CMAKE_BINARY_DIR}/debian_changelog > ${share}/changelog.gz
  DEPENDS rali ${CMAKE_SOURCE_DIR}/CHANGELOG.md ${CMAKE_BINARY_DIR}/debian_changelog
  COMMENT "Manual page and completions" VERBATIM)
if(NOT RALI_SANITIZE AND NOT RALI_COVERAGE)
  set(rali_share_with_all ALL)  # the test of the installed library needs it
endif()
add_custom_target(rali_share ${rali_share_with_all} DEPENDS ${share}/rali.1.gz)
add_dependencies(rali_share rali_library_core rali_library_io)
if(RALI_PYTHON)
  add_dependencies(rali_share rali_python)
endif()

install(TARGETS rali RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
# Below the prefix, so that an installation of a user stays his own; packages have /usr.
install(FILES ${CMAKE_SOURCE_DIR}/cmake/rali@.service DESTINATION lib/systemd/system
  COMPONENT program)
install(FILES ${CMAKE_SOURCE_DIR}/cmake/rali.sysusers DESTINATION lib/sysusers.d
  RENAME rali.conf COMPONENT program)
install(FILES ${share}/rali.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
install(FILES ${share}/rali.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
  RENAME rali COMPONENT program)
install(FILES ${share}/rali.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d
  COMPONENT program)
# zsh of Debian reads the files of packages from another folder than those of the administrator.
install(CODE "
  set(folder site-functions)
  if(CMAKE_INSTALL_PREFIX MATCHES \"/usr$\")
    set(folder vendor-completions)
  endif()
  file(INSTALL \"${share}/_rali\"
    DESTINATION \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/zsh/\${folder}\")"
  COMPONENT program)
set(rali_doc ${CMAKE_INSTALL_DATADIR}/doc)
install(FILES ${share}/CHANGELOG.md.gz ${CMAKE_SOURCE_DIR}/README.md
  DESTINATION ${rali_doc}/rali COMPONENT program)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/docs/ DESTINATION ${rali_doc}/rali/docs COMPONENT program)
# Each package has these of its own.
foreach(part "program;rali" "dev;librali-dev" "python;python3-rali")
  list(GET part 0 component)
  list(GET part 1 package)
  if(component STREQUAL "python" AND NOT RALI_PYTHON)
    continue()
  endif()
  install(FILES ${share}/changelog.gz ${CMAKE_SOURCE_DIR}/cmake/copyright
    ${CMAKE_SOURCE_DIR}/THIRD_PARTY_NOTICES.md DESTINATION ${rali_doc}/${package} COMPONENT ${component})
  list(APPEND rali_components ${component})
endforeach()
include(RaliPackages)
