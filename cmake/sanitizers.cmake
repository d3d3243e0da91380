# -DKASUMI_SANITIZE=address,undefined  or  -DKASUMI_SANITIZE=thread: optimised just enough that every test runs, with all assertions and
# the standard library's index checks.
set(KASUMI_SANITIZE "" CACHE STRING "Sanitizers to build with: address,undefined or thread")
if(KASUMI_SANITIZE)
  set(KASUMI_INSTRUMENTED -Og -UNDEBUG -D_GLIBCXX_ASSERTIONS -fsanitize=${KASUMI_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  # What the address sanitizer sees, too, when it is used: a fifth to two fifths of GCC's time. The fuzzers have them.
  if(KASUMI_SANITIZE MATCHES "address.*undefined")
    list(APPEND KASUMI_INSTRUMENTED -fno-sanitize=null,alignment,object-size)
  endif()
  add_compile_options(${KASUMI_INSTRUMENTED})
  add_link_options(-fsanitize=${KASUMI_SANITIZE})
endif()
# A room that only computes and shares nothing between loops.
# Thread sanitizer: to count its every read would take nine tenths of the time, and what it is given and returns is watched in the rooms
# that hand it over. It is compiled just as without a sanitizer, so that the compiler cache has it. (With the address sanitizer that cannot
# be: Eigen takes memory in another way there.)
# Address sanitizer: optimised by a step more. Eigen's many small functions are inlined then: an appliance in a test takes half the time.
function(kasumi_computes room)
  if(NOT KASUMI_SANITIZE)
    return()
  endif()
  get_target_property(options kasumi_${room} COMPILE_OPTIONS)
  if(KASUMI_SANITIZE MATCHES "thread")
    list(REMOVE_ITEM options ${KASUMI_INSTRUMENTED})
    list(APPEND options ${KASUMI_WARNINGS})
  else()
    list(APPEND options -O1)
  endif()
  set_target_properties(kasumi_${room} PROPERTIES COMPILE_OPTIONS "${options}")
endfunction()

if(KASUMI_SANITIZE MATCHES "address")
  add_library(kasumi_keep_libraries OBJECT tests/sanitizers/keep_libraries.cpp)
endif()

# -DKASUMI_FUZZ=ON with clang++: tests/fuzz is built as libFuzzer programs.
option(KASUMI_FUZZ "Build the fuzzers of tests/fuzz (needs clang++)" OFF)
if(KASUMI_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link,address,undefined -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=address,undefined)
endif()
