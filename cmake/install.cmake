# `cmake --install BUILD` puts the appliance where its unit looks for it; `cpack` (in the build folder) makes a Debian package of
# the same files. Tests and generators are not installed.
set(doc share/doc/kasumi)
install(TARGETS kasumi RUNTIME DESTINATION bin)
install(FILES systemd/kasumi.service DESTINATION lib/systemd/system)
install(FILES systemd/71-kasumi.rules DESTINATION lib/udev/rules.d)
install(FILES systemd/kasumi.sysusers DESTINATION lib/sysusers.d RENAME kasumi.conf)
install(FILES systemd/kasumi.toml DESTINATION ${doc}/examples)
# Laid out as in the repository, so that links between the documents work.
install(FILES README.md CHANGELOG.md DESTINATION ${doc})
install(DIRECTORY docs DESTINATION ${doc} FILES_MATCHING PATTERN "*.md" PATTERN "*.jpg")
install(FILES LICENSE DESTINATION ${doc} RENAME copyright)
# A demo without cameras: kasumi replay /usr/share/kasumi/demo --out demo
install(DIRECTORY fixtures/demo DESTINATION share/kasumi)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_VENDOR "Kasumi")
set(CPACK_PACKAGE_CONTACT "Kasumi <kasumi@localhost>")
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# Run-time dependencies that no linked library shows: the GL driver, fonts for the captions, the user account.
set(CPACK_DEBIAN_PACKAGE_DEPENDS "systemd, udev, libgl1-mesa-dri, fonts-dejavu-core")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "libcamera-ipa, v4l-utils, fonts-vlgothic")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA
  ${PROJECT_SOURCE_DIR}/systemd/deb/postinst ${PROJECT_SOURCE_DIR}/systemd/deb/prerm ${PROJECT_SOURCE_DIR}/systemd/deb/postrm)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
