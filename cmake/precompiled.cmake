# Sanitized builds parse what nearly every file includes once for all rooms and once for all tests, which saves a third of them. The
# plain build does not: there each file shows that it includes what it uses, and g++ 12 forgets in a precompiled header which of the
# standard library's lines not to warn of.
if(KASUMI_SANITIZE)
  set(precompile_by_default ON)
else()
  set(precompile_by_default OFF)
endif()
option(KASUMI_PRECOMPILE "Precompile the headers that nearly every file includes" ${precompile_by_default})

set(room_headers
  <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <map> <memory> <numbers> <optional> <span> <string> <string_view> <vector>
  <fmt/format.h> <glm/glm.hpp> <tl/expected.hpp>)
set(test_headers <gmock/gmock.h> <gtest/gtest.h> <fstream> <random>)

if(KASUMI_PRECOMPILE)
  # SDL's pkg-config defines it, and a precompiled header serves only files that define the same.
  add_compile_definitions(_REENTRANT)
  file(WRITE ${CMAKE_BINARY_DIR}/precompiled.cpp "")
  add_library(kasumi_precompiled_room OBJECT ${CMAKE_BINARY_DIR}/precompiled.cpp)
  target_link_libraries(kasumi_precompiled_room PRIVATE kasumi_warnings tl::expected glm::glm fmt::fmt Threads::Threads)
  target_precompile_headers(kasumi_precompiled_room PRIVATE ${room_headers})
  add_library(kasumi_precompiled_test OBJECT ${CMAKE_BINARY_DIR}/precompiled.cpp)
  target_link_libraries(kasumi_precompiled_test PRIVATE kasumi_warnings tl::expected glm::glm fmt::fmt Threads::Threads GTest::gtest GTest::gmock)
  target_precompile_headers(kasumi_precompiled_test PRIVATE ${room_headers} ${test_headers})
endif()

# kasumi_precompile(TARGET room|test)
function(kasumi_precompile target kind)
  if(KASUMI_PRECOMPILE)
    target_precompile_headers(${target} REUSE_FROM kasumi_precompiled_${kind})
  endif()
endfunction()
