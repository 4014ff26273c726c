# Manual page, completion, scenes and documents of an installation, and the Debian package (docs/install.md).
set(described "${PROJECT_BINARY_DIR}/described")
set(data_dir "${CMAKE_INSTALL_DATADIR}/palpate")
set(doc_dir "${CMAKE_INSTALL_DOCDIR}")

# The program describes itself when it is installed.
install(CODE "
  function(describe file)
    execute_process(COMMAND \"$<TARGET_FILE:palpate>\" \${ARGN} OUTPUT_FILE \"${described}/\${file}\" COMMAND_ERROR_IS_FATAL ANY)
  endfunction()
  file(MAKE_DIRECTORY \"${described}\")
  describe(palpate.1 help --man)
  describe(palpate.bash completion bash)
  describe(_palpate completion zsh)
  describe(palpate.fish completion fish)
  describe(scene.schema.json schema)" COMPONENT programs)
install(FILES "${described}/palpate.1" DESTINATION "${CMAKE_INSTALL_MANDIR}/man1" COMPONENT programs)
install(FILES "${described}/palpate.bash" DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions"
  RENAME palpate COMPONENT programs)
install(FILES "${described}/_palpate" DESTINATION "${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions" COMPONENT programs)
install(FILES "${described}/palpate.fish" DESTINATION "${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d"
  COMPONENT programs)
install(FILES "${described}/scene.schema.json" DESTINATION "${data_dir}" COMPONENT programs)
install(DIRECTORY fixtures/scenes fixtures/materials fixtures/recordings DESTINATION "${data_dir}" COMPONENT programs
  PATTERN invalid EXCLUDE PATTERN "*.in" EXCLUDE)
install(FILES README.md CONTRIBUTING.md CHANGELOG.md CITATION.cff SECURITY.md LICENSE cmake/copyright
  DESTINATION "${doc_dir}" COMPONENT programs)
install(FILES model/EQUATIONS.md DESTINATION "${doc_dir}/model" COMPONENT programs)
install(DIRECTORY docs DESTINATION "${doc_dir}" COMPONENT programs)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME palpate)
set(CPACK_PACKAGE_VENDOR "The Palpate authors")
set(CPACK_PACKAGE_CONTACT "The Palpate authors <palpate@example.invalid>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "libeigen3-dev, libboost-dev, valgrind")
find_program(DPKG_SHLIBDEPS dpkg-shlibdeps)
mark_as_advanced(DPKG_SHLIBDEPS)
if(DPKG_SHLIBDEPS)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
endif()
include(CPack)
