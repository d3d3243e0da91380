# kasumi_test(NAME SOURCES ... USES rooms ... LIBRARIES libraries ... [SHARDS N] [THREADED] [HOSTILE] [FIGURES] [COMPUTES])
#   One GoogleTest program, and a test of ctest for each of its N shards: a process that runs its share of the program's tests one
#   after the other. Each writes its results to test-results/, from which tests/summary counts all tests and names skipped ones. Tests
#   find files, and folders to write to, through tests/places.hpp.
#   THREADED programs share data between our own threads: the thread sanitizer runs them. HOSTILE ones handle external input or
#   faults: the address sanitizer runs them. FIGURES programs measure accuracy over many cases: a quarter of them here, all of
#   them by ./bootstrap figures, and never under a sanitizer. Those and programs that COMPUTE for long themselves are optimised.
#   Each of the first three is a label of ctest, and a target that builds the programs with it: threaded_tests, hostile_tests, figures_tests.
#   A hundred programs of 40 MB: where mold is installed, it links each in a quarter of the time. What is shipped it never links.
if(NOT CMAKE_CROSSCOMPILING AND NOT KASUMI_SANITIZE AND NOT KASUMI_FUZZ)
  find_program(KASUMI_MOLD mold)
endif()
foreach(kind threaded hostile figures)
  add_custom_target(${kind}_tests)
endforeach()
configure_file(${PROJECT_SOURCE_DIR}/tests/places.cpp.in ${CMAKE_BINARY_DIR}/places.cpp @ONLY)
add_library(kasumi_places STATIC ${CMAKE_BINARY_DIR}/places.cpp)
target_include_directories(kasumi_places PUBLIC ${PROJECT_SOURCE_DIR})
target_link_libraries(kasumi_places PRIVATE kasumi_warnings)
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/test-results)

# Where files are compiled together (cmake/unity.cmake), what nearly all tests include is parsed once for all of them. And most tests wait
# for the rooms they try, which are optimised as they are shipped: a third of a test's compilation would go into making itself fast.
function(kasumi_compile_test name computes)
  set(optimisation)
  if(KASUMI_UNITY AND NOT KASUMI_SANITIZE AND NOT computes)
    set(optimisation -O1)
  endif()
  target_compile_options(${name} PRIVATE ${optimisation})
  if(NOT KASUMI_UNITY OR NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    return()
  endif()
  set(headers kasumi_test_headers${optimisation})
  if(NOT TARGET ${headers})
    file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/${headers}.cpp CONTENT "")
    add_library(${headers} OBJECT ${PROJECT_BINARY_DIR}/${headers}.cpp)
    target_link_libraries(${headers} PRIVATE kasumi_warnings GTest::gtest GTest::gmock GTest::gtest_main fmt::fmt glm::glm)
    target_compile_options(${headers} PRIVATE ${optimisation})
    target_precompile_headers(${headers} PRIVATE <gmock/gmock.h> <gtest/gtest.h> <chrono> <filesystem> <fmt/format.h> <fstream>
      <functional> <glm/glm.hpp> <numeric> <optional> <random> <string> <thread> <variant> <vector>)
  endif()
  target_precompile_headers(${name} REUSE_FROM ${headers})
endfunction()

function(kasumi_test name)
  cmake_parse_arguments(TEST "THREADED;HOSTILE;FIGURES;COMPUTES" "SHARDS" "SOURCES;USES;LIBRARIES" ${ARGN})
  add_executable(${name} ${TEST_SOURCES})
  if(TEST_FIGURES OR TEST_COMPUTES)
    kasumi_compile_test(${name} YES)
  else()
    kasumi_compile_test(${name} NO)
  endif()
  target_link_libraries(${name} PRIVATE kasumi_warnings GTest::gtest GTest::gmock GTest::gtest_main kasumi_places ${TEST_LIBRARIES})
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
  if(NOT TEST_SHARDS)
    set(TEST_SHARDS 1)
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
      COST ${TEST_SHARDS}  # the longest begin first
      TIMEOUT 1200)
  endforeach()
endfunction()
