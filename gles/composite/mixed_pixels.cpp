#include "gles/composite/mixed_pixels.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace kasumi {
namespace {

constexpr int kNeighbours_px = 2;  // that matte.glsl asks for, each way

// Multiples of eight from `anchor` on, not after `x`.
int eight_before(int x, int anchor) {
  return x - (((x - anchor) % kEight) + kEight) % kEight;
}

bool is_partly_free(std::uint8_t free_share) {
  return free_share != 0 && free_share != 255;
}

}  // namespace

MixedPixels::MixedPixels(const LayerTexels& layer, const std::vector<PixelBox>& edges,
                         const std::vector<PixelBox>& covered, const Image<glm::u8vec2>* foreground,
                         const MatteNodes* nodes)
    : unit_(layer.unit), is_left_open_(foreground != nullptr) {
  const PixelBox& box = layer.box;
  if (box.empty()) return;
  Image<std::uint8_t> edge(box.right - box.left, box.bottom - box.top, 0);
  const auto set = [&](const std::vector<PixelBox>& rectangles, std::uint8_t value) {
    for (const PixelBox& part : rectangles)
      for (int y = part.top; y < part.bottom; ++y)
        std::fill_n(edge.row(y - box.top) + (part.left - box.left), part.right - part.left, value);
  };
  set(edges, 1);
  set(covered, 0);
  // Nodes change in the middle of their cells: then half of an eight lies between the same two.
  const int anchor = (nodes ? nodes->cell_px : kMatteCell_px) / 2 % 4;
  for (int y = box.top; y < box.bottom; ++y)
    for (int left = eight_before(box.left, anchor); left < box.right; left += kEight) {
      EightPixels eight{.left = left, .top = y};
      for (int i = std::max(0, box.left - left); i < std::min(kEight, box.right - left); ++i) {
        const auto lane = static_cast<std::size_t>(i);
        const glm::vec4& texel = layer.texels.at(left + i - box.left, y - box.top);
        if (texel.a <= 0.0F) continue;
        for (std::size_t c = 0; c < 4; ++c) eight.texel[c][lane] = texel[static_cast<int>(c)];
        eight.whole |= static_cast<std::uint8_t>(1U << lane);
        if (edge.at(left + i - box.left, y - box.top)) eight.edge |= static_cast<std::uint8_t>(1U << lane);
        if (!foreground) continue;
        eight.free_share[lane] = foreground->at(left + i, y).x;
        eight.confidence[lane] = foreground->at(left + i, y).y;
      }
      if (eight.whole != 0) eights_.push_back(eight);
    }
  eights_.shrink_to_fit();  // some megabytes that stay
  edges_ = static_cast<std::size_t>(
      std::ranges::stable_partition(eights_, [](const EightPixels& eight) { return eight.edge != 0; }).begin() -
      eights_.begin());
  if (foreground && nodes) find_band(*nodes);
}

void MixedPixels::find_band(const MatteNodes& nodes) {
  // The eights around mixed pixels, and those of the nodes' pixels.
  const auto each_needed = [&](auto&& need) {
    for (const EightPixels& eight : eights_) {
      const auto first = std::ranges::find_if(eight.free_share, is_partly_free);
      if (first == eight.free_share.end()) continue;
      const auto last = std::find_if(eight.free_share.rbegin(), eight.free_share.rend(), is_partly_free);
      const int left = eight.left + static_cast<int>(first - eight.free_share.begin()) - kNeighbours_px;
      const int right = eight.left + kEight - static_cast<int>(last - eight.free_share.rbegin()) + kNeighbours_px;
      for (int y = eight.top - kNeighbours_px; y <= eight.top + kNeighbours_px; ++y) need(left, right, y);
    }
    for (const MatteNode& node : nodes.nodes)
      for (const auto* taps : {&node.clear, &node.front})
        for (const auto& tap : *taps)
          if (tap) need(tap->x, tap->x + 1, tap->y);
  };
  const int anchor = eights_.empty() ? 0 : eights_.front().left;
  PixelBox& box = band_.box;
  bool first = true;
  each_needed([&](int left, int right, int y) {
    const PixelBox here{eight_before(left, anchor), y, eight_before(right - 1, anchor) + kEight, y + 1};
    box = first ? here
                : PixelBox{std::min(box.left, here.left), std::min(box.top, here.top), std::max(box.right, here.right),
                           std::max(box.bottom, here.bottom)};
    first = false;
  });
  if (box.empty()) return;
  Image<std::uint8_t> needed((box.right - box.left) / kEight, box.bottom - box.top, 0);
  each_needed([&](int left, int right, int y) {
    for (int x = eight_before(left, anchor); x < right; x += kEight)
      needed.at((x - box.left) / kEight, y - box.top) = 1;
  });
  for (int y = 0; y < needed.height(); ++y)
    for (int x = 0; x < needed.width(); ++x) {
      if (needed.at(x, y) == 0) continue;
      const int begin = x;
      while (x < needed.width() && needed.at(x, y) != 0) ++x;
      band_.runs.push_back({box.left + begin * kEight, box.left + x * kEight, box.top + y});
    }

  band_.corner_px = nodes.corner_px;
  band_.cell_px = nodes.cell_px;
  band_.columns = nodes.columns;
  band_.rows = nodes.rows;
  for (const MatteNode& node : nodes.nodes) {
    const glm::dvec2 middle = glm::dvec2(nodes.corner_px) + (glm::dvec2(node.at) + 0.5) * double(nodes.cell_px) - 0.5;
    for (const bool front : {false, true}) {
      const auto first_tap = static_cast<std::uint32_t>(band_.taps.size());
      for (const auto& tap : front ? node.front : node.clear) {
        if (!tap) continue;
        const double far = std::hypot(tap->x - middle.x, tap->y - middle.y) + 1.0;
        band_.taps.push_back(
            {static_cast<std::uint32_t>((tap->y - box.top) * (box.right - box.left) + tap->x - box.left),
             static_cast<float>(1.0 / (front ? far : far * far))});  // as matte.frag has it
      }
      const auto last_tap = static_cast<std::uint32_t>(band_.taps.size());
      if (last_tap > first_tap)
        band_.nodes.push_back({{node.at.x + (front ? nodes.columns : 0), node.at.y}, first_tap, last_tap});
    }
  }
}

}  // namespace kasumi
