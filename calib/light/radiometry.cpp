#include "calib/light/radiometry.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace kasumi {
namespace {

// IEC 61966-2-1. The standard's two thresholds (.04045 and .0031308) leave a gap of 5e-9 between the branches; here
// both directions share the encoded one, so that each undoes the other.
constexpr double kSrgbThreshold = 0.04045;

double srgb_to_light(double encoded) {
  return encoded <= kSrgbThreshold ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}
double srgb_to_encoded(double light) {
  if (light <= kSrgbThreshold / 12.92) return 12.92 * light;
  return std::max(kSrgbThreshold, 1.055 * std::pow(light, 1.0 / 2.4) - 0.055);
}
double srgb_slope(double encoded) {
  return encoded <= kSrgbThreshold ? 1.0 / 12.92 : 2.4 / 1.055 * std::pow((encoded + 0.055) / 1.055, 1.4);
}

// A table is a chain of straight segments; the first and the last go on beyond 0 and 1.
std::size_t segment_of_encoded(const std::vector<double>& table, double encoded) {
  const double last = static_cast<double>(table.size() - 2);
  const double at = encoded * static_cast<double>(table.size() - 1);
  return at > 0.0 ? static_cast<std::size_t>(std::min(at, last)) : 0;
}
std::size_t segment_of_light(const std::vector<double>& table, double light) {
  const auto above = std::upper_bound(table.begin() + 1, table.end() - 1, light);
  return static_cast<std::size_t>(above - table.begin()) - 1;
}

double table_to_light(const std::vector<double>& table, double encoded) {
  const auto i = segment_of_encoded(table, encoded);
  const double part = encoded * static_cast<double>(table.size() - 1) - static_cast<double>(i);
  return table[i] + part * (table[i + 1] - table[i]);
}
double table_to_encoded(const std::vector<double>& table, double light) {
  const auto i = segment_of_light(table, light);
  const double part = (light - table[i]) / (table[i + 1] - table[i]);
  return (static_cast<double>(i) + part) / static_cast<double>(table.size() - 1);
}
double table_slope(const std::vector<double>& table, double encoded) {
  const auto i = segment_of_encoded(table, encoded);
  return (table[i + 1] - table[i]) * static_cast<double>(table.size() - 1);
}

}  // namespace

Response Response::linear() {
  Response response;
  response.kind_ = Kind::linear;
  return response;
}

Response Response::srgb() {
  return {};
}

Response Response::table(std::array<std::vector<double>, 3> light) {
  Response response;
  response.kind_ = Kind::table;
  response.light_ = std::move(light);
  return response;
}

glm::dvec3 Response::to_light(const glm::dvec3& encoded) const {
  if (kind_ == Kind::linear) return encoded;
  glm::dvec3 light;
  for (int c = 0; c < 3; ++c)
    light[c] = kind_ == Kind::srgb ? srgb_to_light(encoded[c]) : table_to_light(light_[c], encoded[c]);
  return light;
}

glm::dvec3 Response::to_encoded(const glm::dvec3& light) const {
  if (kind_ == Kind::linear) return light;
  glm::dvec3 encoded;
  for (int c = 0; c < 3; ++c)
    encoded[c] = kind_ == Kind::srgb ? srgb_to_encoded(light[c]) : table_to_encoded(light_[c], light[c]);
  return encoded;
}

glm::dvec3 Response::slope(const glm::dvec3& encoded) const {
  if (kind_ == Kind::linear) return glm::dvec3{1.0};
  glm::dvec3 slope;
  for (int c = 0; c < 3; ++c)
    slope[c] = kind_ == Kind::srgb ? srgb_slope(encoded[c]) : table_slope(light_[c], encoded[c]);
  return slope;
}

double Vignetting::at(const glm::dvec2& pixel) const {
  const glm::dvec2 offset = (pixel - centre) / radius_px;
  const double r2 = glm::dot(offset, offset);
  const double illumination = 1.0 + r2 * (coefficients[0] + r2 * (coefficients[1] + r2 * coefficients[2]));
  return std::max(illumination, 1e-3);  // the fit is not valid outside the lens's reach
}

}  // namespace kasumi
