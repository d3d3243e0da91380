# kasumi_room(NAME SOURCES ... USES rooms ... LIBRARIES libraries ...)
#   A room is a static library of the sources in its folder. USES are the rooms whose headers it may include; tests/house
#   enforces this.
function(kasumi_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;USES;LIBRARIES;PUBLIC_LIBRARIES" ${ARGN})
  add_library(kasumi_${name} STATIC ${ROOM_SOURCES})
  target_include_directories(kasumi_${name} PUBLIC ${PROJECT_SOURCE_DIR})
  target_link_libraries(kasumi_${name} PRIVATE kasumi_warnings ${ROOM_LIBRARIES})
  target_link_libraries(kasumi_${name} PUBLIC ${ROOM_PUBLIC_LIBRARIES})
  foreach(room ${ROOM_USES})
    target_link_libraries(kasumi_${name} PUBLIC kasumi_${room})
  endforeach()
endfunction()
