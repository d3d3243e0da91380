# -DKASUMI_SANITIZE=address,undefined  or  -DKASUMI_SANITIZE=thread, with KASUMI_UNITY: what each is for is watched by it, with all
# assertions and the standard library's index checks, and optimised just enough that every test runs. All else is compiled exactly as
# without a sanitizer, so that the compiler cache has it from the tests' build.
set(KASUMI_SANITIZE "" CACHE STRING "Sanitizers to build with: address,undefined or thread")

# kasumi_is_under(FOLDER FOLDERS RESULT): whether the folder or one above it is among them.
function(kasumi_is_under folder folders result)
  set(${result} NO PARENT_SCOPE)
  foreach(each ${folders})
    if("${folder}/" MATCHES "^${each}/")
      set(${result} YES PARENT_SCOPE)
    endif()
  endforeach()
endfunction()

# What is watched is said here and nowhere else; tests/house/test_watched.cpp sees that nothing that reads foreign bytes is left out.
# Generators and benches, and what an installer or a researcher starts by hand on pictures of their own: never watched.
set(KASUMI_NEVER_WATCHED fixtures pipeline/lab/bench pipeline/install/calibrate pipeline/install/calibration_report pipeline/lab/comparison pipeline/lab/haze
  pipeline/lab/look pipeline/lab/prove pipeline/lab/sky)
# What solves equations, by Eigen or Ceres, in folders that are watched for what else they do: it is given numbers that the readers have
# checked, in matrices whose sizes are its own, and is three fifths of these folders' compilation. kasumi_compile_together() keeps these
# files apart in every build, so that all builds share them.
set(KASUMI_SOLVERS
  calib/colour/colour.cpp calib/colour/daylight_response.cpp calib/colour/non_negative.cpp calib/colour/sensitivity_fit.cpp
  calib/lens/board_pose.cpp calib/lens/foreign_lens.cpp calib/lens/lens_fit.cpp
  calib/mask/rim_fit.cpp calib/mask/sky_mask.cpp
  estimator/horizon/clear_horizon.cpp estimator/horizon/lowest_sky.cpp
  estimator/landmarks/contrast_tone.cpp estimator/landmarks/extinction.cpp estimator/landmarks/joint_channel.cpp
  estimator/landmarks/path_aerosol.cpp
  estimator/passers/light_mix.cpp
  estimator/sky_camera/aureole_fit.cpp estimator/sky_camera/sky_vignetting.cpp)
if(NOT KASUMI_SANITIZE)
  return()
endif()

set(KASUMI_INSTRUMENTED -Og -UNDEBUG -D_GLIBCXX_ASSERTIONS -fsanitize=${KASUMI_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
if(KASUMI_SANITIZE MATCHES "address.*undefined")
  # What the address sanitizer sees, too, when it is used: a fifth to two fifths of GCC's time. The fuzzers have them.
  list(APPEND KASUMI_INSTRUMENTED -fno-sanitize=null,alignment,object-size)
  # Eigen takes memory in another way under the address sanitizer: its objects could not go between what is watched and what is not.
  list(APPEND KASUMI_INSTRUMENTED -DEIGEN_MALLOC_ALREADY_ALIGNED=1)
  # Hostile bytes reach every room, but not these folders: they are given checked numbers, or what an installer's command has found in
  # a picture, and compute with them; or draw what gles/model and gles/gpu_model have read and counted. Their templates would be the
  # dearest of all to compile once more.
  set(KASUMI_NOT_WATCHED calib/board calib/light calib/pose estimator/air estimator/fusion estimator/light estimator/sky_fit
    gles/air gles/composite gles/light gles/object gles/shadow)
  # The estimator's and the calibration's Eigen: its many small functions are inlined, and an appliance in a test takes half the time.
  set(KASUMI_WATCHED_COMPUTING calib estimator)
  add_library(kasumi_keep_libraries OBJECT tests/sanitizers/keep_libraries.cpp)
else()
  # What shares nothing between threads: what it is given and returns is watched in the rooms that hand it over.
  set(KASUMI_NOT_WATCHED calib estimator)
  set(KASUMI_WATCHED_COMPUTING)
endif()
# Instrumentation hides value ranges from the compiler, which then warns of impossible cases.
list(APPEND KASUMI_INSTRUMENTED -w)
add_link_options(-fsanitize=${KASUMI_SANITIZE})

# kasumi_instrumented(FOLDER RESULT): the options that files in this folder are compiled with; none where it is not watched. FOLDER/solvers
# are those of KASUMI_SOLVERS in it.
function(kasumi_instrumented folder result)
  kasumi_is_under(${folder} "${KASUMI_NEVER_WATCHED};${KASUMI_NOT_WATCHED}" left_out)
  kasumi_is_under(${folder} "${KASUMI_WATCHED_COMPUTING}" computing)
  set(options ${KASUMI_INSTRUMENTED})
  if(left_out OR folder MATCHES "/solvers$")
    set(options)
  elseif(computing)
    list(APPEND options -O1)
  endif()
  set(${result} ${options} PARENT_SCOPE)
endfunction()
