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

# kasumi_test(NAME SOURCES ... USES rooms ... LIBRARIES libraries ... [THREADED])
#   One GoogleTest program; every TEST in it becomes a test of ctest. The tests find files beside themselves through KASUMI_SOURCE_DIR,
#   and write only below KASUMI_TEST_OUTPUT_DIR. THREADED programs are those in which threads of ours share anything: the target
#   threaded_tests builds them, their ctest label is "threaded", and the thread sanitizer runs them.
include(GoogleTest)
add_custom_target(threaded_tests)
function(kasumi_test name)
  cmake_parse_arguments(TEST "THREADED" "" "SOURCES;USES;LIBRARIES" ${ARGN})
  add_executable(${name} ${TEST_SOURCES})
  target_link_libraries(${name} PRIVATE kasumi_warnings GTest::gtest GTest::gmock GTest::gtest_main ${TEST_LIBRARIES})
  foreach(room ${TEST_USES})
    target_link_libraries(${name} PRIVATE kasumi_${room})
  endforeach()
  if(TARGET kasumi_keep_libraries)
    target_link_libraries(${name} PRIVATE kasumi_keep_libraries)
  endif()
  kasumi_precompile(${name} test)
  target_compile_definitions(${name} PRIVATE
    KASUMI_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
    KASUMI_SHARED_DATA_DIR="${PROJECT_SOURCE_DIR}/../shared/data"
    KASUMI_TEST_OUTPUT_DIR="${CMAKE_BINARY_DIR}/test-output")
  set(labels)
  if(TEST_THREADED)
    add_dependencies(threaded_tests ${name})
    set(labels LABELS threaded)
  endif()
  # The tests of one program share its folders, so they run one after the other; programs run side by side.
  gtest_discover_tests(${name} TEST_PREFIX ${name}. DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 900 RESOURCE_LOCK ${name} ${labels})
endfunction()
