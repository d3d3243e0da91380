add_library(kasumi_warnings INTERFACE)
target_compile_options(kasumi_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor -Wold-style-cast
  -Woverloaded-virtual -Wimplicit-fallthrough -Wdouble-promotion
  $<$<CXX_COMPILER_ID:Clang>:-Wthread-safety>)  # base/thread_annotations.hpp
# Instrumentation hides value ranges from the compiler, which then warns of what cannot happen; the plain build holds the line.
if(NOT KASUMI_SANITIZE AND NOT KASUMI_FUZZ)
  target_compile_options(kasumi_warnings INTERFACE -Werror)
endif()
