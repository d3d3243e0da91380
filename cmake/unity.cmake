# -DKASUMI_UNITY=ON: the files of one folder are compiled a few at a time, as one text, which takes less than half the time, since the
# headers they share are parsed once. What lies in an unnamed namespace must then be unique within a folder, as it should be for
# readers. Builds without it show that each file includes what it uses (./bootstrap nightly); they also suit daily work, in which one
# file changes at a time.
option(KASUMI_UNITY "Compile the files of a folder together" OFF)
set(KASUMI_UNITY_FILES 8 CACHE STRING "How many of them at most")

function(kasumi_compile_together target)
  get_target_property(sources ${target} SOURCES)
  get_target_property(home ${target} SOURCE_DIR)
  foreach(source ${sources})
    if(NOT source MATCHES "\\.cpp$")
      continue()
    endif()
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${home} NORMALIZE OUTPUT_VARIABLE path)
    cmake_path(GET path PARENT_PATH folder)
    cmake_path(GET folder FILENAME name)
    string(MD5 key "${folder}")
    math(EXPR files_${key} "0${files_${key}} + 1")
    math(EXPR part "(${files_${key}} - 1) / ${KASUMI_UNITY_FILES}")
    set_property(SOURCE ${path} TARGET_DIRECTORY ${target} PROPERTY UNITY_GROUP "${name}_${part}")
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()

# kasumi_unity(FOLDER): for the targets of a folder and those below it, once they know all their sources.
function(kasumi_unity folder)
  get_property(targets DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target ${targets})
    get_target_property(type ${target} TYPE)
    if(type MATCHES "STATIC_LIBRARY|EXECUTABLE")
      kasumi_compile_together(${target})
    endif()
  endforeach()
  get_property(below DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
  foreach(other ${below})
    kasumi_unity(${other})
  endforeach()
endfunction()
