#include "gles/object/pixel_means.hpp"

#include <algorithm>

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {
namespace {

constexpr std::size_t kMostRows = 56;  // vectors of weights, of the 64 that a renderer needs

PixelBox with_neighbours(const PixelBox& box) {
  return {box.left - kMeansAround_px, box.top - kMeansAround_px, box.right + kMeansAround_px,
          box.bottom + kMeansAround_px};
}

std::size_t rows_of(const PointSpread& spread) {
  return 2 * spread.weights().size() + 3;
}

}  // namespace

std::vector<glm::dvec3> mean_weights(const std::vector<double>& spread_weights) {
  const int radius = static_cast<int>(spread_weights.size()) - 1, reach = radius + 2;
  std::vector<glm::dvec3> weights;
  for (int row = -reach; row <= reach; ++row) {
    glm::dvec3 sums{0.0};
    for (const auto& offset : kLatticeOffsets) {
      const int apart = std::abs(row - offset[1]);
      if (offset[0] >= 0 && apart <= radius) sums[offset[0]] += spread_weights[static_cast<std::size_t>(apart)];
    }
    weights.push_back(sums / static_cast<double>(kLatticeOffsets.size()));
  }
  return weights;
}

bool PixelMeans::have_room_for(const PointSpread& spread) {
  return rows_of(spread) <= kMostRows;
}

Result<PixelMeans> PixelMeans::create(const PointSpread& spread, int size, int spare, const GlInfo& info,
                                      Programs& programs) {
  const auto program = programs.find(ProgramKind::mean, {fmt::format("SPREAD_RADIUS {}", spread.weights().size() - 1)});
  if (!program) return fail(program.error());
  const int side = LayerTile::most_pixels(spare) + 2 * kMeansAround_px;
  auto means = LayerBuffer::create(side, side, false, info, "the buffer for the pixels' means");
  if (!means) return fail(means.error());
  return PixelMeans(mean_weights(spread.weights()), size, side, std::move(*means), **program);
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
  program_->set("fragment_to_sample", tile.layer_fragment_to_sample(whole));
  program_->set("sample_step", glm::dvec2{1.0 / size_});
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
