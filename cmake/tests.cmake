# kasumi_test(NAME SOURCES ... USES rooms ... LIBRARIES libraries ... [SHARDS N] [THREADED] [HOSTILE] [AS_SHIPPED] [FIGURES]
#             [COMPUTES] [WAITS])
#   One GoogleTest program, and a test of ctest for each of its N shards: a process that runs its share of the program's tests one
#   after the other. Each writes its results to test-results/, from which tests/summary counts all tests, names skipped ones and takes
#   the processor time. Tests find files, and folders to write to, through tests/places.hpp.
#   THREADED programs share data between our own threads: the thread sanitizer runs them. HOSTILE ones handle external input or
#   faults: the address sanitizer runs them. With KASUMI_LEAVE_TO_SANITIZERS (the gate's) both kinds run only there, but for those that
#   measure the memory or replace the calls of the program AS_SHIPPED. FIGURES programs measure accuracy over many cases: ./bootstrap
#   figures builds and runs them, the gate does not. Those and programs that COMPUTE for long themselves are optimised. Of programs that
#   mostly WAIT, for other processes or on the clock, one runs beside those that keep the cores busy.
#   THREADED, HOSTILE and FIGURES are each a label of ctest, and a target that builds the programs with it: threaded_tests,
#   hostile_tests, figures_tests.
#   A program holds a room or a large part of one, since each is another 40 MB to link; where mold is installed, it does so in a
#   quarter of the time. What is shipped it never links.
if(NOT CMAKE_CROSSCOMPILING AND NOT KASUMI_FUZZ)
  find_program(KASUMI_MOLD mold)
endif()
option(KASUMI_LEAVE_TO_SANITIZERS "The sanitizer builds run some tests, so this build leaves them out" OFF)
foreach(kind threaded hostile figures)
  add_custom_target(${kind}_tests)
endforeach()
configure_file(${PROJECT_SOURCE_DIR}/tests/places.cpp.in ${CMAKE_BINARY_DIR}/places.cpp @ONLY)
# tests/made_once.hpp: which folder holds what this generator made.
file(GLOB_RECURSE sources RELATIVE ${PROJECT_SOURCE_DIR} CONFIGURE_DEPENDS
  base/*.[ch]pp base/*.glsl calib/*.[ch]pp capture/*.[ch]pp fixtures/*.[ch]pp
  fixtures/temple.glb fixtures/pagoda-matt.glb tests/pipeline/recorded.cpp)
list(JOIN sources "\n" lines)
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/made_once.list CONTENT "${lines}" @ONLY)
list(TRANSFORM sources PREPEND ${PROJECT_SOURCE_DIR}/)
add_custom_command(OUTPUT ${CMAKE_BINARY_DIR}/made_once_folder.cpp
  COMMAND ${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR} -DLIST=${CMAKE_BINARY_DIR}/made_once.list
    -DOUT=${CMAKE_BINARY_DIR}/made_once_folder.cpp -P ${PROJECT_SOURCE_DIR}/cmake/made_once.cmake
  DEPENDS ${sources} ${CMAKE_BINARY_DIR}/made_once.list ${PROJECT_SOURCE_DIR}/cmake/made_once.cmake VERBATIM)
add_library(kasumi_places STATIC ${CMAKE_BINARY_DIR}/places.cpp ${CMAKE_BINARY_DIR}/made_once_folder.cpp
  ${PROJECT_SOURCE_DIR}/tests/made_once.cpp ${PROJECT_SOURCE_DIR}/tests/main.cpp)
target_include_directories(kasumi_places PUBLIC ${PROJECT_SOURCE_DIR})
target_link_libraries(kasumi_places PRIVATE kasumi_warnings GTest::gtest GTest::gmock)
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/test-results)

# Where files are compiled together (cmake/unity.cmake), what nearly all tests include is parsed once for all of them. And most tests wait
# for the rooms they try, which are optimised as they are shipped: a third of a test's compilation would go into making itself fast.
function(kasumi_compile_test name computes)
  set(optimisation)
  if(KASUMI_UNITY AND NOT KASUMI_SANITIZE AND NOT computes)
    set(optimisation -O1)
  endif()
  target_compile_options(${name} PRIVATE ${optimisation} ${KASUMI_INSTRUMENTED})
  if(NOT KASUMI_UNITY OR NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    return()
  endif()
  set(headers kasumi_test_headers${optimisation})
  if(NOT TARGET ${headers})
    file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/${headers}.cpp CONTENT "")
    add_library(${headers} OBJECT ${PROJECT_BINARY_DIR}/${headers}.cpp)
    target_link_libraries(${headers} PRIVATE kasumi_warnings GTest::gtest GTest::gmock fmt::fmt glm::glm)
    target_compile_options(${headers} PRIVATE ${optimisation} ${KASUMI_INSTRUMENTED})
    target_precompile_headers(${headers} PRIVATE ${PROJECT_SOURCE_DIR}/base/outside/compiled_formatting.hpp <gmock/gmock.h>
      <gtest/gtest.h> <chrono> <filesystem> <fmt/format.h> <fstream> <functional> <glm/glm.hpp> <numeric> <optional> <random> <string>
      <thread> <variant> <vector>)
  endif()
  target_precompile_headers(${name} REUSE_FROM ${headers})
endfunction()

function(kasumi_test name)
  cmake_parse_arguments(TEST "THREADED;HOSTILE;AS_SHIPPED;FIGURES;COMPUTES;WAITS" "SHARDS" "SOURCES;USES;LIBRARIES" ${ARGN})
  add_executable(${name} ${TEST_SOURCES})
  set(left_to_sanitizers NO)
  if(KASUMI_LEAVE_TO_SANITIZERS AND NOT KASUMI_SANITIZE AND NOT TEST_AS_SHIPPED AND (TEST_THREADED OR TEST_HOSTILE))
    set(left_to_sanitizers YES)
  endif()
  if(TEST_FIGURES OR left_to_sanitizers)
    set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL ON)
  endif()
  if(TEST_FIGURES OR TEST_COMPUTES)
    kasumi_compile_test(${name} YES)
  else()
    kasumi_compile_test(${name} NO)
  endif()
  target_link_libraries(${name} PRIVATE kasumi_warnings GTest::gtest GTest::gmock kasumi_places ${TEST_LIBRARIES})
  foreach(room ${TEST_USES})
    target_link_libraries(${name} PRIVATE kasumi_${room})
  endforeach()
  if(KASUMI_MOLD)
    target_link_options(${name} PRIVATE -fuse-ld=mold)
  endif()
  if(TARGET kasumi_keep_libraries)
    target_link_libraries(${name} PRIVATE kasumi_keep_libraries)
  endif()
  set(labels)
  foreach(kind THREADED HOSTILE FIGURES)
    if(TEST_${kind})
      string(TOLOWER ${kind} label)
      list(APPEND labels ${label})
      add_dependencies(${label}_tests ${name})
    endif()
  endforeach()
  if(left_to_sanitizers)
    return()
  endif()
  if(NOT TEST_SHARDS)
    set(TEST_SHARDS 1)
  endif()
  set(half_cores 2)
  if(TEST_WAITS)
    set(half_cores 1)
  endif()
  # The thread sanitizer's deadlock detector gives up at 64 held locks, and the GL driver leaves some held with each context: few tests
  # in one process there.
  if(KASUMI_SANITIZE MATCHES "thread" AND TEST_THREADED)
    set(TEST_SHARDS 12)
  endif()
  foreach(shard RANGE 1 ${TEST_SHARDS})
    set(test ${name})
    if(TEST_SHARDS GREATER 1)
      string(APPEND test .${shard}of${TEST_SHARDS})
    endif()
    math(EXPR index "${shard} - 1")
    add_test(NAME ${test} COMMAND ${name})
    set_tests_properties(${test} PROPERTIES
      ENVIRONMENT "GTEST_TOTAL_SHARDS=${TEST_SHARDS};GTEST_SHARD_INDEX=${index};GTEST_OUTPUT=xml:${CMAKE_BINARY_DIR}/test-results/${test}.xml"
      LABELS "${labels}"
      PROCESSORS ${half_cores}
      COST ${TEST_SHARDS}  # the longest begin first
      TIMEOUT 1200)
  endforeach()
endfunction()
