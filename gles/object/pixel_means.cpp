#include "gles/object/pixel_means.hpp"

#include <algorithm>

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {
namespace {

PixelBox with_neighbours(const PixelBox& box) {
  return {box.left - kMeansAround_px, box.top - kMeansAround_px, box.right + kMeansAround_px,
          box.bottom + kMeansAround_px};
}

}  // namespace

std::vector<glm::dvec4> mean_weights(const std::vector<double>& spread_weights) {
  const int radius = static_cast<int>(spread_weights.size()) - 1, reach = radius + 2;
  std::vector<glm::dvec4> weights;
  for (int row = -reach; row <= reach; ++row) {
    glm::dvec4 sums{0.0};
    for (const auto& offset : kLatticeOffsets) {
      const int apart = std::abs(row - offset[1]);
      if (offset[0] >= 0 && apart <= radius) sums[offset[0]] += spread_weights[static_cast<std::size_t>(apart)];
    }
    weights.push_back(sums / static_cast<double>(kLatticeOffsets.size()));
  }
  return weights;
}

Result<PixelMeans> PixelMeans::create(const PointSpread& spread, int size, int spare, const GlInfo& info,
                                      Programs& programs) {
  const Defines defines{fmt::format("SPREAD_RADIUS {}", spread.weights().size() - 1)};
  return create(mean_weights(spread.weights()), defines, size, size, spare, info, programs);
}

Result<PixelMeans> PixelMeans::create(const CoarseSpread& spread, int spare, const GlInfo& info, Programs& programs) {
  const CoarseWeights& weights = spread.weights();
  const Defines defines{fmt::format("COARSE_STEP {}", spread.step()), fmt::format("BEFORE {}", weights.before),
                        fmt::format("COUNT {}", weights.weights.size())};
  return create(weights.weights, defines, spread.lattice(), spread.size(), spare, info, programs);
}

Result<PixelMeans> PixelMeans::create(std::vector<glm::dvec4> weights, const Defines& defines, int lattice, int size,
                                      int spare, const GlInfo& info, Programs& programs) {
  const auto program = programs.find(ProgramKind::mean, defines);
  if (!program) return fail(program.error());
  const int side = LayerTile::most_pixels(spare) + 2 * kMeansAround_px;
  auto means = LayerBuffer::create(side, side, false, info, "the buffer for the pixels' means");
  if (!means) return fail(means.error());
  return PixelMeans(std::move(weights), lattice, size, side, std::move(*means), **program);
}

void PixelMeans::draw(const LayerBuffer& samples, const LayerTile& tile, const PixelBox& needed) const {
  const PixelBox whole = with_neighbours(tile.box()), part = with_neighbours(needed);
  const glm::ivec2 size{whole.right - whole.left, whole.bottom - whole.top};
  glBindFramebuffer(GL_FRAMEBUFFER, means_.framebuffer.name());
  glViewport(0, 0, size.x, size.y);
  glEnable(GL_SCISSOR_TEST);
  glScissor(part.left - whole.left, part.top - whole.top, part.right - part.left, part.bottom - part.top);
  program_->use();
  glActiveTexture(GL_TEXTURE0 + kLayerUnit);
  glBindTexture(GL_TEXTURE_2D, samples.texture.name());
  program_->set("samples", kLayerUnit);
  program_->set("viewport", glm::dvec4(0.0, 0.0, 0.5 * glm::dvec2(size)));
  program_->set("fragment_to_sample", tile.layer_fragment_to_sample(whole, lattice_));
  program_->set("sample_step", glm::dvec2{1.0 / size_});
  program_->set("lattice_size", double(lattice_));
  program_->set("weights", weights_);
  draw_square();
  glDisable(GL_SCISSOR_TEST);
}

void PixelMeans::bind(const Program& program, const LayerTile& tile, const PixelBox& layer) const {
  glActiveTexture(GL_TEXTURE0 + kLayerUnit);
  glBindTexture(GL_TEXTURE_2D, means_.texture.name());
  program.set("means", kLayerUnit);
  program.set("mean_step", 1.0 / side_);
  const PixelBox whole = with_neighbours(tile.box());
  program.set("mean_place", glm::dvec3(layer.left - whole.left, layer.top - whole.top, 1.0 / side_));
}

}  // namespace kasumi
