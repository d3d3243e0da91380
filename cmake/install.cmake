# `cmake --install BUILD` puts the appliance and its reporter where their units look for them; `cpack` (in the build folder) makes Debian
# packages: kasumi and kasumi-report of the same files, and kasumi-kiosk, which closes the machine it stands on. Tests and generators
# are not installed.
set(doc share/doc/kasumi)
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME kasumi)
install(TARGETS kasumi RUNTIME DESTINATION bin)
# A build's id is a hash that includes its debug information, and with it the folder of the checkout: of all that remains after
# stripping, it alone would differ between two builds of one commit (.ci/same-twice). Nothing asks for it: no dump is ever written.
foreach(shipped kasumi kasumi_rare_files kasumi_rare_models kasumi-report)
  target_link_options(${shipped} PRIVATE LINKER:--build-id=none)
endforeach()
install(TARGETS kasumi_rare_files kasumi_rare_models LIBRARY DESTINATION lib/kasumi)
install(FILES systemd/kasumi.service systemd/kasumi-content.path systemd/kasumi-content.service
  systemd/kasumi-stick@.service systemd/kasumi-stick-mount@.service DESTINATION lib/systemd/system)
install(PROGRAMS systemd/wait-before-start DESTINATION lib/kasumi)
install(FILES systemd/71-kasumi.rules DESTINATION lib/udev/rules.d)
install(FILES systemd/kasumi.sysusers DESTINATION lib/sysusers.d RENAME kasumi.conf)
install(FILES systemd/kasumi.toml DESTINATION ${doc}/examples)
install(FILES ${manual}/kasumi.1.gz DESTINATION share/man/man1)
install(FILES ${manual}/kasumi.toml.5.gz DESTINATION share/man/man5)
install(FILES ${manual}/kasumi.bash DESTINATION share/bash-completion/completions RENAME kasumi)
# Laid out as in the repository, so that links between the documents work.
install(FILES README.md CHANGELOG.md DESTINATION ${doc})
install(DIRECTORY docs DESTINATION ${doc} FILES_MATCHING PATTERN "*.md" PATTERN "*.jpg")
install(FILES systemd/deb/copyright DESTINATION ${doc})
install(FILES systemd/deb/lintian-overrides DESTINATION share/lintian/overrides RENAME kasumi)
install(FILES ${PROJECT_BINARY_DIR}/bill/kasumi.spdx.json DESTINATION ${doc})
# A demo without cameras: kasumi replay /usr/share/kasumi/demo --out demo
install(DIRECTORY fixtures/demo DESTINATION share/kasumi)

# A program of its own, which may be left out: it speaks to the network.
install(TARGETS kasumi-report RUNTIME DESTINATION bin COMPONENT report)
install(FILES systemd/kasumi-report.service systemd/kasumi-fetched.path DESTINATION lib/systemd/system COMPONENT report)
install(FILES ${manual}/kasumi-report.1.gz DESTINATION share/man/man1 COMPONENT report)
install(FILES ${manual}/kasumi-report.bash DESTINATION share/bash-completion/completions RENAME kasumi-report COMPONENT report)
install(FILES systemd/report.toml DESTINATION share/doc/kasumi-report/examples COMPONENT report)
install(FILES systemd/report/kasumi.rules.yml systemd/report/grafana-dashboard.json DESTINATION share/kasumi/report COMPONENT report)
install(FILES systemd/deb/copyright DESTINATION share/doc/kasumi-report COMPONENT report)
install(FILES ${PROJECT_BINARY_DIR}/bill/kasumi-report.spdx.json DESTINATION share/doc/kasumi-report COMPONENT report)
install(FILES systemd/deb-report/lintian-overrides DESTINATION share/lintian/overrides RENAME kasumi-report COMPONENT report)

# Only by name (cmake --install BUILD --component kiosk), for it changes the whole machine.
foreach(file system logind journald)
  install(FILES systemd/kiosk/${file}.conf DESTINATION lib/systemd/${file}.conf.d RENAME 50-kasumi-kiosk.conf
    COMPONENT kiosk EXCLUDE_FROM_ALL)
endforeach()
install(FILES systemd/kiosk/sysctl.conf DESTINATION lib/sysctl.d RENAME 60-kasumi-kiosk.conf COMPONENT kiosk EXCLUDE_FROM_ALL)
install(FILES systemd/kiosk/72-kasumi-kiosk.rules DESTINATION lib/udev/rules.d COMPONENT kiosk EXCLUDE_FROM_ALL)
install(FILES systemd/deb/copyright DESTINATION share/doc/kasumi-kiosk COMPONENT kiosk EXCLUDE_FROM_ALL)
install(FILES ${PROJECT_BINARY_DIR}/bill/kasumi-kiosk.spdx.json DESTINATION share/doc/kasumi-kiosk COMPONENT kiosk EXCLUDE_FROM_ALL)
install(FILES systemd/deb-kiosk/lintian-overrides DESTINATION share/lintian/overrides RENAME kasumi-kiosk COMPONENT kiosk EXCLUDE_FROM_ALL)

# What changed since when, in the form that Debian's tools read.
string(TIMESTAMP packed_on "%a, %d %b %Y %H:%M:%S +0000" UTC)
function(install_changelog package component)
  set(file ${PROJECT_BINARY_DIR}/changes/${package}/changelog)
  file(WRITE ${file} "${package} (${PROJECT_VERSION}) bookworm; urgency=medium\n\n"
    "  * What changed: /usr/share/doc/kasumi/CHANGELOG.md\n\n -- ${CPACK_PACKAGE_CONTACT}  ${packed_on}\n")
  execute_process(COMMAND gzip -9n --force ${file} COMMAND_ERROR_IS_FATAL ANY)
  install(FILES ${file}.gz DESTINATION share/doc/${package} COMPONENT ${component} ${ARGN})
endfunction()
# The packages' maintainer: set when building for others, as for Debian's own tools.
set(KASUMI_MAINTAINER "" CACHE STRING "Maintainer of the Debian packages: \"Name <address>\"; empty: $DEBFULLNAME <$DEBEMAIL>")
if(KASUMI_MAINTAINER)
  set(CPACK_PACKAGE_CONTACT "${KASUMI_MAINTAINER}")
elseif(NOT "$ENV{DEBEMAIL}" STREQUAL "")
  set(CPACK_PACKAGE_CONTACT "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
else()
  set(CPACK_PACKAGE_CONTACT "Unpublished build of Kasumi <nobody@example.org>")
endif()
install_changelog(kasumi kasumi)
install_changelog(kasumi-report report)
install_changelog(kasumi-kiosk kiosk EXCLUDE_FROM_ALL)

set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL kasumi kiosk report)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_VENDOR "Kasumi")
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
# The first line of every description, and what follows it in each.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "vanished building, seen again under today's air")
set(CPACK_DEBIAN_KASUMI_DESCRIPTION "A fisheye camera watches the sky, from whose pictures the turbidity of the
air is estimated again and again. A scene camera watches the hill, and into
its picture a building is drawn with physically based aerial perspective, for
months, unattended.")
set(CPACK_DEBIAN_KASUMI_PACKAGE_NAME kasumi)
set(CPACK_DEBIAN_KASUMI_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_KIOSK_PACKAGE_NAME kasumi-kiosk)
set(CPACK_DEBIAN_KIOSK_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_KIOSK_DESCRIPTION "This package closes the machine it stands on, for a kiosk in public: no
keyboard, watchdogs, a bounded journal.")
set(CPACK_DEBIAN_KIOSK_PACKAGE_DEPENDS "kasumi (>= ${PROJECT_VERSION}), systemd, udev, procps")
set(CPACK_DEBIAN_KIOSK_PACKAGE_CONTROL_EXTRA
  ${PROJECT_SOURCE_DIR}/systemd/deb-kiosk/postinst ${PROJECT_SOURCE_DIR}/systemd/deb-kiosk/postrm)
set(CPACK_DEBIAN_REPORT_PACKAGE_NAME kasumi-report)
set(CPACK_DEBIAN_REPORT_PACKAGE_SECTION net)
set(CPACK_DEBIAN_REPORT_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_REPORT_DESCRIPTION "This package is the reporter, which tells the network how the kiosk is, to
whom its configuration allows.")
set(CPACK_DEBIAN_REPORT_PACKAGE_DEPENDS "kasumi (>= ${PROJECT_VERSION}), systemd")
set(CPACK_DEBIAN_REPORT_PACKAGE_RECOMMENDS "ca-certificates")
set(CPACK_DEBIAN_REPORT_PACKAGE_SUGGESTS "msmtp-mta")
set(CPACK_DEBIAN_REPORT_PACKAGE_CONTROL_EXTRA
  ${PROJECT_SOURCE_DIR}/systemd/deb-report/postinst ${PROJECT_SOURCE_DIR}/systemd/deb-report/prerm ${PROJECT_SOURCE_DIR}/systemd/deb-report/postrm)
# Run-time dependencies that no linked library shows: the GL driver, fonts for the captions, the user account.
set(CPACK_DEBIAN_KASUMI_PACKAGE_DEPENDS "systemd, udev, libgl1-mesa-dri, fonts-dejavu-core")
set(CPACK_DEBIAN_KASUMI_PACKAGE_RECOMMENDS "dbus, libcamera-ipa, v4l-utils, fonts-vlgothic")
set(CPACK_DEBIAN_KASUMI_PACKAGE_SUGGESTS "kasumi-kiosk, kasumi-report")
set(CPACK_DEBIAN_KASUMI_PACKAGE_CONTROL_EXTRA
  ${PROJECT_SOURCE_DIR}/systemd/deb/postinst ${PROJECT_SOURCE_DIR}/systemd/deb/prerm ${PROJECT_SOURCE_DIR}/systemd/deb/postrm)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
