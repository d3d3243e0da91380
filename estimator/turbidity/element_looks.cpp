#include "estimator/turbidity/element_looks.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/common.hpp>
#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"
#include "estimator/turbidity/element_maps.hpp"

namespace kasumi {

namespace {

// Relative step of light per step of the encoded value, by channel and level: how coarsely dark elements are quantised.
class RelativeSteps {
 public:
  RelativeSteps(const Response& response, double quantum) {
    for (std::size_t i = 1; i < steps_.size(); ++i) {
      const glm::dvec3 level{static_cast<double>(i) / kLast};
      steps_[i] = glm::vec3(quantum * response.slope(level) / glm::max(response.to_light(level), glm::dvec3{1e-9}));
    }
    steps_[0] = steps_[1];
  }
  glm::vec3 at(const glm::vec3& encoded) const { return {step(encoded, 0), step(encoded, 1), step(encoded, 2)}; }

 private:
  static constexpr int kLast = 255;  // as an 8-bit picture has levels
  float step(const glm::vec3& encoded, int c) const {
    return steps_[static_cast<std::size_t>(std::clamp(encoded[c], 0.0f, 1.0f) * kLast)][c];
  }
  std::array<glm::vec3, kLast + 1> steps_{};
};

}  // namespace

float ElementLooks::rough(double scatter, double least) const {
  std::vector<float> textures = some_of(*this, [&](int x, int y) { return texture(y, x); });
  return std::max(static_cast<float>(least), static_cast<float>(scatter) * quantile_in_place(textures, 0.25));
}

ElementLooks looks_of(const SkyPicture& picture, const Camera& camera, const ElementLight& light) {
  const RelativeSteps steps(camera.response, picture.quantum);
  const cv::Mat1f none(light.use.height(), light.use.width(), 0.0f);
  ElementLooks looks{none.clone(), {}, none.clone(), none.clone(), {}, none.clone(), none.clone()};
  cv::Mat1f unseen = none.clone();
  for (int y = 0; y < none.rows; ++y)
    for (int x = 0; x < none.cols; ++x) {
      const PixelUse use = light.use.at(x, y);
      if (use == PixelUse::saturated || use == PixelUse::dark) unseen(y, x) = 1.0f;
      if (use != PixelUse::clear) continue;
      const glm::vec3& channels = light.light.at(x, y);
      const glm::vec3 step = steps.at(picture.encoded.at(x, y));
      looks.known(y, x) = 1.0f;
      looks.luminance(y, x) = light.log_luminance.at(x, y);
      looks.colour(y, x) = std::log(channels.r / channels.b);
      looks.luminance_step(y, x) = step.g;
      looks.colour_step(y, x) = std::hypot(step.r, step.b);
    }
  cv::boxFilter(unseen, unseen, CV_32F, {5, 5}, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::compare(unseen, 5.5, looks.alone, cv::CMP_GT);
  looks.texture = texture_of(looks.luminance, looks.known);
  const MeansOver means(looks.known, 3);
  looks.luminance = means.of(looks.luminance);
  looks.colour = means.of(looks.colour);
  return looks;
}

}  // namespace kasumi
