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
add_custom_target(manual ALL DEPENDS ${manuals} ${manual}/kasumi.toml.5)
