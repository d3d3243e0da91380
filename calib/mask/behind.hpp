// What is behind that which sways before it.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <opencv2/core.hpp>

#include "base/image.hpp"

namespace kasumi {

// A pixel's pictures in one kind, or in two: ln of light.
struct PixelKinds {
  glm::vec3 dark{0.0F}, bright{0.0F};
  bool two = false;
};

// `light`: of one pixel over time.
glm::vec3 median_of(const std::vector<glm::vec3>& light);
PixelKinds kinds_of(const std::vector<glm::vec3>& light);

// Followed from the rim of what sways inwards.
class Behind {
 public:
  // `kinds`: of the swaying pixels; of those around them `dark` is their median. It must outlive this.
  Behind(const Image<PixelKinds>& kinds, const cv::Mat1b& swaying);
  bool known(int x, int y) const { return known_(y, x) != 0; }
  const glm::vec3& at(int x, int y) const { return light_.at(x, y); }  // ln of light

 private:
  std::optional<glm::vec3> like(const glm::vec3& behind, int x, int y) const;
  void fill_gaps();
  void set(int x, int y, const glm::vec3& light);
  void wake_neighbours(int x, int y);
  void follow();

  const Image<PixelKinds>& kinds_;
  Image<glm::vec3> light_;
  cv::Mat1b known_;
  std::deque<glm::ivec2> waiting_;
};

}  // namespace kasumi
