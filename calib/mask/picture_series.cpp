#include "calib/mask/picture_series.hpp"

#include <algorithm>

namespace kasumi {
namespace {

std::array<std::array<float, 256>, 3> light_of_codes(const Response& response) {
  std::array<std::array<float, 256>, 3> table{};
  for (std::size_t i = 0; i < 256; ++i) {
    const auto light = response.to_light(glm::dvec3(static_cast<double>(i) / 255.0));
    for (int c = 0; c < 3; ++c)
      table[static_cast<std::size_t>(c)][i] = std::max(0.0F, static_cast<float>(light[c])) + kFaintestLight;
  }
  return table;
}

}  // namespace

PictureSeries::PictureSeries(std::span<const Image<Rgb8>> pictures, const Response& response)
    : pictures_(pictures), table_(light_of_codes(response)), gains_(pictures.size(), glm::vec3(1.0F)) {
  const auto& reference = pictures[pictures.size() / 2];
  for (std::size_t t = 0; t < pictures.size(); ++t)
    for (int c = 0; c < 3; ++c) {
      std::vector<float> ratios;
      for (std::size_t i = 0; i < reference.elements().size(); i += 37)
        ratios.push_back(light(reference.elements()[i], c) / light(pictures[t].elements()[i], c));
      gains_[t][c] = median_in_place(ratios);
    }
}

glm::vec3 PictureSeries::at(std::size_t t, int x, int y) const {
  const Rgb8& pixel = pictures_[t].at(x, y);
  return gains_[t] * glm::vec3(light(pixel, 0), light(pixel, 1), light(pixel, 2));
}

std::vector<glm::vec3> PictureSeries::over_time(int x, int y) const {
  std::vector<glm::vec3> values;
  for (std::size_t t = 0; t < size(); ++t) values.push_back(at(t, x, y));
  return values;
}

}  // namespace kasumi
