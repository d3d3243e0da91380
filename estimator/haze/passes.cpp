// The flow between two pixels is computed once: it is added to the first and kept until the second, `offset_px` further
// on, is reached and has it subtracted. By then both have been read, so one picture is enough.
#include "estimator/haze/passes.hpp"

#include <algorithm>
#include <cstddef>

namespace kasumi {
namespace {

constexpr std::size_t kInCache = std::size_t{4} << 20;  // bytes

// Handles pixels from `light` on and those `offset_px` to their right and below. `from_left` and `from_above` hold the
// flow to the neighbours before and receive the same for these pixels, from_left at `offset_px` on.
void flow_right_and_down(int count, int offset_px, const float* across, const glm::vec4* right, const float* down,
                         const glm::vec4* below, glm::vec4* from_left, glm::vec4* from_above, glm::vec4* light) {
  for (int x = 0; x < count; ++x) {
    const glm::vec4 own = light[x];
    const glm::vec4 from_right = across[x] * (right[x] - own), from_below = down[x] * (below[x] - own);
    light[x] = own + (from_right - from_left[x]) + (from_below - from_above[x]);
    from_left[x + offset_px] = from_right;
    from_above[x] = from_below;
  }
}

// One pass, row by row from the top.
class Pass {
 public:
  Pass(const FlowRule& rule, const FlowMap& map)
      : rule_(rule),
        map_(&map),
        width_(map.wanted_px2.width()),
        height_(map.wanted_px2.height()),
        across_(static_cast<std::size_t>(width_ + rule.offset_px)),
        down_(static_cast<std::size_t>(width_)),
        from_left_(across_.size()),
        beyond_right_(static_cast<std::size_t>(rule.offset_px)),
        from_above_(width_, rule.offset_px),
        beyond_bottom_(width_, rule.offset_px) {}
  int offset_px() const { return rule_.offset_px; }
  // Its working set from row to row, including the rows between it and the previous pass.
  static std::size_t bytes(const FlowRule& rule, int width) {
    return 2 * static_cast<std::size_t>(rule.offset_px) * static_cast<std::size_t>(width) * sizeof(glm::vec4);
  }

  // The rows down to y + offset_px must be as the previous pass left them.
  void replace_row(int y, Image<glm::vec4>& light) {
    const int d = rule_.offset_px, in_picture = width_ - d;
    if (y == 0) flow_from_beyond_top(light);
    if (y + d == height_)
      for (int i = 0; i < d; ++i) std::copy_n(light.row(height_ - 1 - i), width_, beyond_bottom_.row(i));
    const bool inside = y + d < height_;
    weigh_along_row(y);
    weigh_down_column(y, inside ? y + d : 2 * height_ - 1 - y - d);

    glm::vec4 *row = light.row(y), *from_above = from_above_.row(y % d);
    const glm::vec4* below = inside ? light.row(y + d) : beyond_bottom_.row(y + d - height_);
    const float *across = across_.data() + d, *down = down_.data();
    glm::vec4 *from_left = from_left_.data(), *beyond = beyond_right_.data();
    for (int i = 0; i < d; ++i) {
      from_left[i] = across_[static_cast<std::size_t>(i)] * (row[i] - row[d - 1 - i]);
      beyond[i] = row[width_ - 1 - i];
    }
    flow_right_and_down(in_picture, d, across, row + d, down, below, from_left, from_above, row);
    flow_right_and_down(d, d, across + in_picture, beyond, down + in_picture, below + in_picture,
                        from_left + in_picture, from_above + in_picture, row + in_picture);
  }

 private:
  void weigh(const Image<float>* steps, int x, int y, int other_x, int other_y, int count, float* flow) const {
    conductances(rule_, map_->wanted_px2.row(y) + x, map_->wanted_px2.row(other_y) + other_x, count, flow);
    if (steps != nullptr) stop_at_steps(steps->row(y) + x, steps->row(other_y) + other_x, count, flow);
  }
  // across_[i]: between pixels i - d and i.
  void weigh_along_row(int y) {
    const int d = rule_.offset_px;
    const auto* steps = map_->steps_along_row;
    weigh(steps, 0, y, d, y, width_ - d, across_.data() + d);
    for (int i = 0; i < d; ++i) {  // mirrored
      weigh(steps, d - 1 - i, y, i, y, 1, across_.data() + i);
      weigh(steps, width_ - d + i, y, width_ - 1 - i, y, 1, across_.data() + width_ + i);
    }
  }
  void weigh_down_column(int y, int other_y) { weigh(map_->steps_down_column, 0, y, 0, other_y, width_, down_.data()); }
  void flow_from_beyond_top(const Image<glm::vec4>& light) {
    const int d = rule_.offset_px;
    for (int y = 0; y < d; ++y) {
      const int mirrored = d - 1 - y;
      weigh_down_column(y, mirrored);
      for (int x = 0; x < width_; ++x)
        from_above_.at(x, y) = down_[static_cast<std::size_t>(x)] * (light.at(x, y) - light.at(x, mirrored));
    }
  }

  FlowRule rule_;
  const FlowMap* map_;
  int width_, height_;
  std::vector<float> across_, down_;
  std::vector<glm::vec4> from_left_, beyond_right_;
  Image<glm::vec4> from_above_;     // of row y: row y % offset_px
  Image<glm::vec4> beyond_bottom_;  // mirrored, with their values before they were replaced
};

}  // namespace

void run_passes(const std::vector<FlowRule>& rules, const FlowMap& map, Image<glm::vec4>& light) {
  for (auto rule = rules.begin(); rule != rules.end();) {
    std::vector<Pass> together;
    int behind = 0;
    for (std::size_t bytes = 0; rule != rules.end(); ++rule) {
      bytes += Pass::bytes(*rule, light.width());
      if (!together.empty() && bytes > kInCache) break;
      together.emplace_back(*rule, map);
      behind += rule->offset_px;
    }
    for (int front = 0; front < light.height() + behind; ++front) {
      int y = front;
      for (auto& pass : together) {
        y -= pass.offset_px();
        if (y >= 0 && y < light.height()) pass.replace_row(y, light);
      }
    }
  }
}

}  // namespace kasumi
