// The Earth's size. Two figures, for two questions; they are not to be mixed.
#pragma once

namespace kasumi {

// A sphere of the mean radius, rounded to kilometres (the ellipsoid's is 6371.009 km): horizons, the curve of sea and
// land, how a path of light sags. base/sky/air_path.glsl has the same for the GPU.
constexpr double kEarthRadius_m = 6371000.0;

// The ellipsoid WGS 84: where a latitude, a longitude and an altitude above it lie.
constexpr double kWgs84SemiMajorAxis_m = 6378137.0;
constexpr double kWgs84Flattening = 1.0 / 298.257223563;

}  // namespace kasumi
