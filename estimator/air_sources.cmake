# From T to what the air does with light.
set(AIR_SOURCES)
set(AIR_LIBRARIES Ceres::ceres opencv_core opencv_imgproc)

# Vector code for the passes over whole pictures: four pixels' conductances at a time, but one pixel's four values.
set_source_files_properties(haze_conductance.cpp haze_invariant.cpp PROPERTIES
  COMPILE_OPTIONS "-O3;-fno-math-errno;-fno-trapping-math")
set_source_files_properties(haze_passes.cpp PROPERTIES
  COMPILE_OPTIONS "-O3;-fno-tree-loop-vectorize")
