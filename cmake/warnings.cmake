# Warnings are shown in every build of ours and are errors in the gate's (CMakePresets.json): a new warning of another compiler must
# not break anyone's build. The fuzzers' instrumentation hides value ranges from the compiler, which then warns of impossible cases.
add_library(kasumi_warnings INTERFACE)
set(KASUMI_WARNINGS
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor -Wold-style-cast
  -Woverloaded-virtual -Wimplicit-fallthrough
  $<$<CXX_COMPILER_ID:GNU>:-Wdouble-promotion>  # Clang's also counts a float that is given where a double is asked
  $<$<CXX_COMPILER_ID:Clang>:-Wthread-safety>)  # base/thread_annotations.hpp
if(NOT KASUMI_FUZZ)
  target_compile_options(kasumi_warnings INTERFACE ${KASUMI_WARNINGS})
endif()
