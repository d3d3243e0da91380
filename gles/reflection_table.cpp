#include "gles/reflection_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/units.hpp"
#include "gles/gl.hpp"

namespace kasumi {
namespace {

constexpr int kSize = 32;
constexpr double kLeastRoughness = 1e-3;  // a mirror: the integrals hold, their samples coincide

// The cosine between normal and facet that a share u of GGX's facets lie within.
double facet_cosine(double u, double alpha) {
  return std::sqrt((1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u));
}

}  // namespace

// Facets drawn evenly from GGX's distribution; what each gives back is 4 V n.l v.h / n.h of what falls in.
GivenBack given_back(double across, double roughness) {
  constexpr int kTilts = 64, kTurns = 16;
  const double alpha = std::pow(std::max(roughness, kLeastRoughness), 2), a2 = alpha * alpha;
  const double sideways = std::sqrt(1.0 - across * across);
  const auto shadow = [&](double outer, double inner) { return outer * std::sqrt(inner * inner * (1.0 - a2) + a2); };
  GivenBack sum{0.0, 0.0};
  for (int i = 0; i < kTilts; ++i) {
    const double nh = facet_cosine((i + 0.5) / kTilts, alpha), tilt = std::sqrt(1.0 - nh * nh);
    for (int j = 0; j < kTurns; ++j) {
      const double vh = sideways * tilt * std::cos(kPi * (j + 0.5) / kTurns) + across * nh;
      const double nl = 2.0 * vh * nh - across;
      if (vh <= 0.0 || nl <= 0.0) continue;
      const double weight = 2.0 * nl * vh / nh / (shadow(nl, across) + shadow(across, nl)) / (kTilts * kTurns);
      sum.all += weight;
      sum.edge += weight * std::pow(1.0 - vh, 5);
    }
  }
  return sum;
}

Smeared smeared(double roughness) {
  constexpr int kTilts = 4096;
  const double alpha = std::pow(std::max(roughness, kLeastRoughness), 2);
  double weights = 0.0;
  Smeared sum{0.0, 0.0};
  for (int i = 0; i < kTilts; ++i) {
    const double nh = facet_cosine((i + 0.5) / kTilts, alpha);
    const double nl = 2.0 * nh * nh - 1.0;
    if (nl <= 0.0) continue;
    weights += nl;
    sum.first += nl * nl;
    sum.second += nl * 0.5 * (3.0 * nl * nl - 1.0);
  }
  return {sum.first / weights, sum.second / weights};
}

Result<GlTexture> make_reflection_table(int unit) {
  const auto byte = [](double value) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 1.0) * 255.0));
  };
  std::vector<std::uint8_t> texels;
  for (int y = 0; y < kSize; ++y) {
    const double roughness = static_cast<double>(y) / (kSize - 1);
    const Smeared smear = smeared(roughness);
    for (int x = 0; x < kSize; ++x) {
      const double root = std::max(static_cast<double>(x) / (kSize - 1), 0.01);
      const GivenBack back = given_back(root * root, roughness);
      for (const double value : {back.all, back.edge, smear.first, smear.second}) texels.push_back(byte(value));
    }
  }
  GlTexture texture = make_texture();
  glActiveTexture(GL_TEXTURE0 + static_cast<unsigned>(unit));
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, kSize, kSize, 0, GL_RGBA, GL_UNSIGNED_BYTE, texels.data());
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
  if (auto made = check_gl("making the table of reflections"); !made) return tl::unexpected(made.error());
  return texture;
}

}  // namespace kasumi
