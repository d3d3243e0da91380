#include "gles/object/point_spread.hpp"

#include <cmath>

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {

int spread_radius(double sigma) {
  return static_cast<int>(std::ceil(3.5 * sigma)) + 1;  // a narrow discrete Gaussian has a heavier tail
}

std::vector<double> gaussian_weights(double sigma) {
  const double variance = sigma * sigma;
  const int radius = spread_radius(sigma);
  std::vector<double> weights;
  double sum = 0.0;
  for (int i = 0; i <= radius; ++i) {
    weights.push_back(std::exp(-variance) * std::cyl_bessel_i(i, variance));
    sum += (i == 0 ? 1.0 : 2.0) * weights.back();
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

Result<PointSpread> PointSpread::create(double sigma, int size, bool in_8_bits, const GlInfo& info,
                                        Programs& programs) {
  auto weights = gaussian_weights(sigma);
  Defines defines{fmt::format("SPREAD_RADIUS {}", weights.size() - 1)};
  if (in_8_bits) defines.insert("LAYER_IN_8_BITS");
  const auto program = programs.find(ProgramKind::spread, defines);
  if (!program) return fail(program.error());
  auto between = LayerBuffer::create(size, size, in_8_bits, info, "the buffer for the point spread");
  if (!between) return fail(between.error());
  return PointSpread(std::move(weights), size, std::move(*between), **program);
}

void PointSpread::pass(const LayerBuffer& from, const LayerBuffer& to, const glm::dvec2& along, int width,
                       int height) const {
  program_->use();
  program_->set("samples", kLayerUnit);
  program_->set("dither_pattern", kDitherUnit);
  program_->set("sample_step", glm::dvec2(1.0 / size_));
  program_->set("stride", glm::dvec2(1.0));
  program_->set("weights", weights_);
  program_->set("along", along / double(size_));
  glViewport(0, 0, width, height);
  glBindFramebuffer(GL_FRAMEBUFFER, to.framebuffer.name());
  glActiveTexture(GL_TEXTURE0 + kLayerUnit);
  glBindTexture(GL_TEXTURE_2D, from.texture.name());
  draw_square();
}

const LayerBuffer& PointSpread::along_rows(const LayerBuffer& samples, int width, int height) const {
  pass(samples, between_, {1.0, 0.0}, width, height);
  return between_;
}

void PointSpread::apply(const LayerBuffer& samples, int width, int height) const {
  pass(along_rows(samples, width, height), samples, {0.0, 1.0}, width, height);
}

}  // namespace kasumi
