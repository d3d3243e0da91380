# Manual pages and bash completion, made by the programs themselves from their help texts, and from the example configuration.
set(manual ${PROJECT_BINARY_DIR}/manual)
file(MAKE_DIRECTORY ${manual})
foreach(program kasumi kasumi-report)
  add_custom_command(OUTPUT ${manual}/${program}.1 ${manual}/${program}.1.gz ${manual}/${program}.bash
    COMMAND ${program} --manual page > ${manual}/${program}.1
    COMMAND gzip -9nk --force ${manual}/${program}.1
    COMMAND ${program} --manual bash > ${manual}/${program}.bash
    DEPENDS ${program} VERBATIM)
  list(APPEND manuals ${manual}/${program}.1 ${manual}/${program}.bash)
endforeach()
add_custom_command(OUTPUT ${manual}/kasumi.toml.5 ${manual}/kasumi.toml.5.gz
  COMMAND kasumi --manual keys < ${PROJECT_SOURCE_DIR}/systemd/kasumi.toml > ${manual}/kasumi.toml.5
  COMMAND gzip -9nk --force ${manual}/kasumi.toml.5
  DEPENDS kasumi ${PROJECT_SOURCE_DIR}/systemd/kasumi.toml VERBATIM)
# What the packages are made of. Each build writes them anew: a library of the system may be another by then.
set(made_of_kasumi $<TARGET_FILE:kasumi> $<TARGET_FILE:kasumi_rare_files> $<TARGET_FILE:kasumi_rare_models>)
set(made_of_kasumi-report $<TARGET_FILE:kasumi-report>)
set(made_of_kasumi-kiosk)  # no program
foreach(package kasumi kasumi-report kasumi-kiosk)
  set(bill ${PROJECT_BINARY_DIR}/bill/${package}.spdx.json)
  add_custom_command(OUTPUT ${bill}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${PROJECT_BINARY_DIR}/bill
    COMMAND env OBJDUMP=${CMAKE_OBJDUMP} ${PROJECT_SOURCE_DIR}/cmake/bill-of-materials ${package} ${PROJECT_VERSION}
      ${made_of_${package}} > ${bill}
    DEPENDS ${made_of_${package}} ${PROJECT_SOURCE_DIR}/cmake/bill-of-materials ${PROJECT_SOURCE_DIR}/cmake/compiled-in VERBATIM)
  list(APPEND manuals ${bill})
endforeach()
add_custom_target(manual ALL DEPENDS ${manuals} ${manual}/kasumi.toml.5)
