# -DKASUMI_SANITIZE=address,undefined  or  -DKASUMI_SANITIZE=thread; the standard library's index checks are enabled as well.
if(KASUMI_SANITIZE)
  add_compile_options(-fsanitize=${KASUMI_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${KASUMI_SANITIZE})
  add_compile_definitions(_GLIBCXX_ASSERTIONS)
endif()
# not_watched_for_races(ROOM): a room that only computes and shares nothing between loops. Counting its every read would
# take nine tenths of the thread sanitizer's time; what it is given and returns is watched in the rooms that hand it over.
function(not_watched_for_races room)
  if(KASUMI_SANITIZE MATCHES "thread")
    target_compile_options(kasumi_${room} PRIVATE -fno-sanitize=thread)
  endif()
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
