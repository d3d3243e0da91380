# From T to what the air does with light.
set(AIR_SOURCES
  scattering.cpp weather.cpp attenuation.cpp attenuation_nodes.cpp
  horizon.cpp clear_horizon.cpp horizon_segmentation.cpp horizon_measure.cpp
  sensitivity_error.cpp sky_colours.cpp
  horizon_strips.cpp horizon_clear_sky.cpp horizon_lowest_sky.cpp horizon_sky_ring.cpp airlight.cpp
  measured_sky.cpp object_light.cpp site_sky.cpp clear_sky_light.cpp retarget.cpp
  land_around.cpp picture_noise.cpp picture_paths.cpp depth_from_haze.cpp
  landmark_contrast.cpp landmark_extinction.cpp landmark_air.cpp air_path.cpp dome.cpp dome_table.cpp)
set(AIR_LIBRARIES Ceres::ceres opencv_core opencv_imgproc)

# Haze that blurs.
list(APPEND AIR_SOURCES haze_conductance.cpp haze_diffusion.cpp haze_holes.cpp haze_invariant.cpp haze_margin.cpp haze_passes.cpp
  haze_picture.cpp haze_range.cpp haze_steps.cpp)
# Vector code for the passes over whole pictures: four pixels' conductances at a time, but one pixel's four values.
set_source_files_properties(haze_conductance.cpp haze_invariant.cpp PROPERTIES
  COMPILE_OPTIONS "-O3;-fno-math-errno;-fno-trapping-math" SKIP_PRECOMPILE_HEADERS ON)
set_source_files_properties(haze_passes.cpp PROPERTIES
  COMPILE_OPTIONS "-O3;-fno-tree-loop-vectorize" SKIP_PRECOMPILE_HEADERS ON)
