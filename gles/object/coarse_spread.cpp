#include "gles/object/coarse_spread.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"
#include "gles/object/point_spread.hpp"

namespace kasumi {
namespace {

constexpr int kMostStep = 4;  // a component of a vector each
// A wave that the coarser lattice takes for a longer one is left with e^(-2 pi^2 kKept) of its height at most, where
// first^2 second^2 = kKept step^2 sigma^2.
constexpr double kKept = 0.38;

// The shares of a pixel's samples by their distance from its middle, -2 .. 2 columns or rows. The mean over them is not
// quite the product of both ways: by a thousandth of an edge's height at the narrowest spread.
std::array<double, 5> samples_by_distance() {
  std::array<double, 5> shares{};
  for (const auto& offset : kLatticeOffsets) shares[static_cast<std::size_t>(offset[0] + 2)] += 1.0 / 17.0;
  return shares;
}

}  // namespace

SplitSpread split_spread(double sigma) {
  const double variance = sigma * sigma;
  const int step = std::min(static_cast<int>(sigma / (2.0 * std::sqrt(kKept))), kMostStep);
  if (step < 2) return {1, sigma, 0.0};
  // The second as narrow as it may be: it is what each pixel pays for.
  const double rest = std::max(variance - 4.0 * kKept * step * step, 0.0);
  const double second = 0.5 * (variance - sigma * std::sqrt(rest));
  return {step, std::sqrt(variance - second), std::sqrt(second)};
}

CoarseWeights coarse_weights(const SplitSpread& split) {
  const auto spread = gaussian_weights(split.second);
  const int radius = static_cast<int>(spread.size()) - 1, reach = radius + 2;
  const auto weight_at = [&](int distance) {
    double sum = 0.0;
    const auto shares = samples_by_distance();
    for (int i = 0; i < 5; ++i)
      if (const int apart = std::abs(distance - (i - 2)); apart <= radius)
        sum += shares[static_cast<std::size_t>(i)] * spread[static_cast<std::size_t>(apart)];
    return sum;
  };
  CoarseWeights made;
  made.before = reach / split.step;
  made.weights.resize(static_cast<std::size_t>(made.before + (split.step - 1 + reach) / split.step + 1));
  for (int phase = 0; phase < split.step; ++phase) {
    double sum = 0.0;
    for (std::size_t i = 0; i < made.weights.size(); ++i)
      sum += made.weights[i][phase] = weight_at((static_cast<int>(i) - made.before) * split.step - phase);
    for (glm::dvec4& weight : made.weights) weight[phase] /= sum;
  }
  return made;
}

CoarseSpread::CoarseSpread(const SplitSpread& split, int lattice, int size, LayerBuffer rows, LayerBuffer both,
                           const Program& program)
    : split_(split),
      weights_(coarse_weights(split)),
      first_weights_(gaussian_weights(split.first)),
      lattice_(lattice),
      size_(size),
      rows_(std::move(rows)),
      both_(std::move(both)),
      program_(&program) {}

Result<CoarseSpread> CoarseSpread::create(const SplitSpread& split, int size, const GlInfo& info, Programs& programs) {
  const auto program =
      programs.find(ProgramKind::spread, {fmt::format("SPREAD_RADIUS {}", spread_radius(split.first))});
  if (!program) return fail(program.error());
  const int kept = (size + split.step - 1) / split.step;
  auto rows = LayerBuffer::create(kept, size, false, info, "the buffer for the point spread");
  if (!rows) return fail(rows.error());
  auto both = LayerBuffer::create(kept, kept, false, info, "the buffer for the point spread");
  if (!both) return fail(both.error());
  return CoarseSpread(split, size, kept, std::move(*rows), std::move(*both), **program);
}

void CoarseSpread::pass(const LayerBuffer& from, glm::ivec2 from_size, const LayerBuffer& to, glm::ivec2 to_size,
                        const glm::dvec2& along, const LayerTile& tile, const PixelBox& pixels) const {
  program_->use();
  program_->set("samples", kLayerUnit);
  program_->set("sample_step", 1.0 / glm::dvec2(from_size));
  program_->set("stride", glm::dvec2(1.0) + (split_.step - 1.0) * along);
  program_->set("weights", first_weights_);
  program_->set("along", along / glm::dvec2(from_size));
  glViewport(0, 0, to_size.x, to_size.y);
  glBindFramebuffer(GL_FRAMEBUFFER, to.framebuffer.name());
  glActiveTexture(GL_TEXTURE0 + kLayerUnit);
  glBindTexture(GL_TEXTURE_2D, from.texture.name());
  tile.draw(pixels, lattice_);
}

void CoarseSpread::along_rows(const LayerBuffer& samples, const LayerTile& tile, const PixelBox& needed) const {
  const int reach = weights_.reach_samples(split_.step) + static_cast<int>(first_weights_.size());
  pass(samples, {lattice_, lattice_}, rows_, {size_, lattice_}, {1.0, 0.0}, tile, grown(needed, pixels_of(reach)));
}

const LayerBuffer& CoarseSpread::along_columns(const LayerTile& tile, const PixelBox& needed) const {
  const int reach = weights_.reach_samples(split_.step);
  pass(rows_, {size_, lattice_}, both_, {size_, size_}, {0.0, 1.0}, tile, grown(needed, pixels_of(reach)));
  return both_;
}

}  // namespace kasumi
