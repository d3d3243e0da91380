#include "estimator/horizon/horizon.hpp"

#include <algorithm>
#include <cmath>

namespace kasumi {
namespace {

// Signed, in (-pi, pi].
double azimuth_difference(Radians a, Radians b) {
  return std::remainder(a.value - b.value, 2.0 * kPi);
}

HorizonColumn mix(const HorizonColumn& a, const HorizonColumn& b, double t) {
  const double azimuth = std::remainder(a.azimuth.value + t * azimuth_difference(b.azimuth, a.azimuth), 2.0 * kPi);
  return {{azimuth < 0.0 ? azimuth + 2.0 * kPi : azimuth},
          {std::lerp(a.zenith.value, b.zenith.value, t)},
          (1.0 - t) * a.light + t * b.light,
          std::lerp(a.quality, b.quality, t)};
}

}  // namespace

std::string_view name_of(HorizonLight::Source source) {
  switch (source) {
    case HorizonLight::Source::none: return "none";
    case HorizonLight::Source::scene_camera: return "scene camera";
    case HorizonLight::Source::sky_camera: return "sky camera";
    case HorizonLight::Source::model: return "sky model";
  }
  return "unknown";
}

HorizonColumn column_at(const HorizonLight& horizon, Radians azimuth) {
  const auto& columns = horizon.columns;
  // Relative to the middle of the view, so that a view across north stays in one piece.
  const Radians middle = columns[columns.size() / 2].azimuth;
  const double wanted = azimuth_difference(azimuth, middle);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double here = azimuth_difference(columns[i].azimuth, middle);
    if (here < wanted) continue;
    if (i == 0) return columns.front();
    const double before = azimuth_difference(columns[i - 1].azimuth, middle);
    return here > before ? mix(columns[i - 1], columns[i], (wanted - before) / (here - before)) : columns[i];
  }
  return columns.back();
}

HorizonLight blend(const HorizonLight& previous, const HorizonLight& current, double weight) {
  if (!previous.usable()) return current;
  if (!current.usable()) return previous;
  HorizonLight blended = current;
  for (HorizonColumn& column : blended.columns) {
    column = mix(column_at(previous, column.azimuth), column, std::clamp(weight, 0.0, 1.0));
  }
  return blended;
}

}  // namespace kasumi
