// The Earth's size. The two models serve different purposes and must not be mixed.
#pragma once

namespace kasumi {

// A sphere of the mean radius, rounded to kilometres (the ellipsoid's is 6371.009 km): for horizons, the curvature of
// sea and land, and light paths. base/sky/air_path.glsl repeats the value for the GPU.
constexpr double kEarthRadius_m = 6371000.0;

// The WGS 84 ellipsoid: to place a latitude, longitude and altitude.
constexpr double kWgs84SemiMajorAxis_m = 6378137.0;
constexpr double kWgs84Flattening = 1.0 / 298.257223563;

}  // namespace kasumi
