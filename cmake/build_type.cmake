# Before project(): the default build type. Line numbers are what a report from the field or a sanitizer needs; a debugger
# wants -DCMAKE_BUILD_TYPE=Debug. Sanitized builds are optimised just enough that every test runs in them, and keep the assertions.
set(KASUMI_SANITIZE "" CACHE STRING "Sanitizers to build with: address,undefined or thread")
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE RelWithDebInfo)
endif()
if(KASUMI_SANITIZE)
  set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-Og -g1" CACHE STRING "Flags of the default build")
else()
  set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O2 -g1 -DNDEBUG" CACHE STRING "Flags of the default build")
endif()
