# What was compiled before, in whichever checkout, is not compiled again: continuous integration starts from a clean one each time.
# Paths are relative to the checkout in the cache's eyes, and nothing compiled but places.cpp knows where it lies.
find_program(KASUMI_CCACHE ccache)
if(KASUMI_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER
    ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1
    CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime ${KASUMI_CCACHE})
endif()
