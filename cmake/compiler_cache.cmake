# Code compiled before, in any checkout, is not compiled again: continuous integration always starts from a clean checkout.
# The cache sees paths relative to the checkout, and only places.cpp compiles in the checkout's location.
find_program(KASUMI_CCACHE ccache)
if(KASUMI_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER
    ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1
    CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime ${KASUMI_CCACHE})
endif()
