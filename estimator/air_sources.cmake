# From T to what the air does with light.
set(AIR_SOURCES
  scattering.cpp weather.cpp attenuation.cpp attenuation_nodes.cpp
  horizon.cpp clear_horizon.cpp horizon_segmentation.cpp horizon_measure.cpp
  sensitivity_error.cpp sky_colours.cpp
  horizon_strips.cpp horizon_clear_sky.cpp horizon_lowest_sky.cpp horizon_sky_ring.cpp airlight.cpp
  measured_sky.cpp object_light.cpp clear_sky_light.cpp retarget.cpp air_path.cpp dome.cpp)
set(AIR_LIBRARIES Ceres::ceres opencv_core opencv_imgproc)
