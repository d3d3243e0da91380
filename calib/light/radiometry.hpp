// From pixel values to light: response curve and vignetting.
#pragma once

#include <array>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace kasumi {

// Encoded value (0..1) <-> linear light (0..1), the same curve for the three channels unless a table says otherwise.
// Every curve goes on monotonically outside 0..1.
class Response {
 public:
  enum class Kind { linear, srgb, table };
  static Response linear();
  static Response srgb();
  // Linear light at evenly spaced encoded values 0..1, strictly increasing from 0 to 1, one table per channel.
  static Response table(std::array<std::vector<double>, 3> light);

  Kind kind() const { return kind_; }
  glm::dvec3 to_light(const glm::dvec3& encoded) const;
  glm::dvec3 to_encoded(const glm::dvec3& light) const;
  // d light / d encoded, to propagate quantisation and noise.
  glm::dvec3 slope(const glm::dvec3& encoded) const;

 private:
  Kind kind_ = Kind::srgb;
  std::array<std::vector<double>, 3> light_;
};

// Relative illumination 1 + v2 r^2 + v4 r^4 + v6 r^6 at r = distance from the optical centre / reference radius. Always
// > 0.
struct Vignetting {
  glm::dvec2 centre{};
  double radius_px = 1.0;
  std::array<double, 3> coefficients{};
  double at(const glm::dvec2& pixel) const;
};

}  // namespace kasumi
