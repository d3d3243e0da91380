# kasumi_room(NAME SOURCES ... USES rooms ... LIBRARIES libraries ...)
#   A room is a static library of the sources in its folder. USES are the rooms whose headers it may include; tests/house holds
#   the code to it.
function(kasumi_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;USES;LIBRARIES;PUBLIC_LIBRARIES" ${ARGN})
  add_library(kasumi_${name} STATIC ${ROOM_SOURCES})
  target_include_directories(kasumi_${name} PUBLIC ${PROJECT_SOURCE_DIR})
  target_link_libraries(kasumi_${name} PRIVATE kasumi_warnings ${ROOM_LIBRARIES})
  target_link_libraries(kasumi_${name} PUBLIC ${ROOM_PUBLIC_LIBRARIES})
  foreach(room ${ROOM_USES})
    target_link_libraries(kasumi_${name} PUBLIC kasumi_${room})
  endforeach()
  kasumi_precompile(kasumi_${name} room)
endfunction()

# kasumi_test(NAME SOURCES ... USES rooms ... LIBRARIES libraries ... [THREADED] [FIGURES] [HOSTILE])
#   One GoogleTest program; every TEST in it becomes a test of ctest. The tests find files, and where they may write, through
#   tests/places.hpp. THREADED programs are those in which threads of ours share anything: the target
#   threaded_tests builds them, their ctest label is "threaded", and the thread sanitizer runs them. FIGURES programs measure how exact
#   something is over many cases; their label is "figures", and sanitizers leave them out: other tests run the same code once.
#   HOSTILE programs give our code what others may have broken, by chance or on purpose: files, models, cameras, displays. The target
#   hostile_tests builds them, their label is "hostile", and the address sanitizer runs them.
include(GoogleTest)
add_custom_target(threaded_tests)
add_custom_target(hostile_tests)
configure_file(${PROJECT_SOURCE_DIR}/tests/places.cpp.in ${CMAKE_BINARY_DIR}/places.cpp @ONLY)
add_library(kasumi_places STATIC ${CMAKE_BINARY_DIR}/places.cpp)
target_include_directories(kasumi_places PUBLIC ${PROJECT_SOURCE_DIR})
target_link_libraries(kasumi_places PRIVATE kasumi_warnings)
function(kasumi_test name)
  cmake_parse_arguments(TEST "THREADED;FIGURES;HOSTILE" "" "SOURCES;USES;LIBRARIES" ${ARGN})
  add_executable(${name} ${TEST_SOURCES})
  target_link_libraries(${name} PRIVATE kasumi_warnings GTest::gtest GTest::gmock GTest::gtest_main kasumi_places ${TEST_LIBRARIES})
  foreach(room ${TEST_USES})
    target_link_libraries(${name} PRIVATE kasumi_${room})
  endforeach()
  if(TARGET kasumi_keep_libraries)
    target_link_libraries(${name} PRIVATE kasumi_keep_libraries)
  endif()
  kasumi_precompile(${name} test)
  set(labels)
  if(TEST_THREADED)
    add_dependencies(threaded_tests ${name})
    list(APPEND labels threaded)
  endif()
  if(TEST_FIGURES)
    list(APPEND labels figures)
  endif()
  if(TEST_HOSTILE)
    add_dependencies(hostile_tests ${name})
    list(APPEND labels hostile)
  endif()
  # The tests of one program share its folders, so they run one after the other; programs run side by side.
  gtest_discover_tests(${name} TEST_PREFIX ${name}. DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 900 RESOURCE_LOCK ${name})
  # gtest_discover_tests takes no list for a property.
  if(labels)
    file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/${name}_labels.cmake
      "if(${name}_TESTS)\n  set_tests_properties(\${${name}_TESTS} PROPERTIES LABELS \"${labels}\")\nendif()\n")
    set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${CMAKE_CURRENT_BINARY_DIR}/${name}_labels.cmake)
  endif()
endfunction()
