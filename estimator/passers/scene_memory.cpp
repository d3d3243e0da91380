#include "estimator/passers/scene_memory.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

namespace kasumi {
namespace {

constexpr std::size_t kOfMedian = 5;                 // the fewest of which two may show a passer
constexpr Duration kOld = std::chrono::minutes(40);  // the sun has gone on by ten degrees
constexpr std::size_t kNewest = 3;                   // never forgotten for being alike

std::uint8_t median_of_five(std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d, std::uint8_t e) {
  // Neither the least nor the greatest of four is the median of five.
  const std::uint8_t low = std::max(std::min(a, b), std::min(c, d)), high = std::min(std::max(a, b), std::max(c, d));
  return std::max(std::min(low, high), std::min(std::max(low, high), e));
}

Image<std::uint8_t> median(const std::vector<RememberedFrame>& of, Image<std::uint8_t> RememberedFrame::*plane) {
  Image<std::uint8_t> made = of[0].*plane;
  for (std::size_t i = 0; i < made.elements().size(); ++i) {
    const auto at = [&](std::size_t k) { return (of[k].*plane).elements()[i]; };
    made.elements()[i] = median_of_five(at(0), at(1), at(2), at(3), at(4));
  }
  return made;
}

// How far two pictures are from each other under the exposure that makes them most alike, squared and relative.
double apart2(const RememberedFrame& a, const RememberedFrame& b) {
  double aa = 0.0, ab = 0.0, bb = 0.0;
  for (std::size_t i = 0; i < a.light.elements().size(); i += 3) {
    const glm::dvec3 p(glm::sqrt(a.light.elements()[i])), q(glm::sqrt(b.light.elements()[i]));
    aa += glm::dot(p, p);
    ab += glm::dot(p, q);
    bb += glm::dot(q, q);
  }
  return 1.0 - ab * ab / std::max(aa * bb, 1e-12);
}

}  // namespace

glm::vec3 light_of_cell(const glm::vec3& yuv, const YuvToRgb& conversion, const Tone& tone) {
  const glm::vec3 from = yuv / 255.0F + glm::vec3{0.0F, 128.0F / 255.0F, 128.0F / 255.0F} - conversion.offset;
  glm::vec3 code;
  for (std::size_t c = 0; c < 3; ++c) code[static_cast<glm::length_t>(c)] = 255.0F * glm::dot(conversion.rows[c], from);
  return tone.to_light(code);
}

bool SceneMemory::add(RememberedFrame picture, Duration apart, const PicturePart& part, const Tone& tone) {
  const Instant now = picture.at;
  if (!recent_.empty() && (now < recent_.back().at || now - recent_.back().at > std::chrono::seconds(10)))
    recent_.clear();
  recent_.push_back(std::move(picture));
  if (recent_.size() > kOfMedian) recent_.erase(recent_.begin());
  if (recent_.size() < kOfMedian) return false;
  if (!pictures_.empty() && now >= pictures_.back().at && now - pictures_.back().at < apart) return false;
  RememberedFrame made;
  made.at = now;
  made.luma = median(recent_, &RememberedFrame::luma);
  made.blue = median(recent_, &RememberedFrame::blue);
  made.red = median(recent_, &RememberedFrame::red);
  const Image<glm::vec3> cells = means_of_cells(made.luma, made.blue, made.red, part.place().cell_px);
  made.light = Image<glm::vec3>(cells.width(), cells.height());
  const YuvToRgb conversion = yuv_to_rgb(part.encoding());
  for (std::size_t i = 0; i < cells.elements().size(); ++i)
    made.light.elements()[i] = light_of_cell(cells.elements()[i], conversion, tone);
  make_room(now);
  pictures_.push_back(std::move(made));
  return true;
}

void SceneMemory::make_room(Instant now) {
  if (pictures_.size() < kMost) return;
  std::size_t out = 0;
  if (now - pictures_[0].at < kOld) {
    double least = 1e9;
    for (std::size_t i = 0; i + kNewest < pictures_.size(); ++i)
      for (std::size_t k = i + 1; k < pictures_.size(); ++k)
        if (const double apart = apart2(pictures_[i], pictures_[k]); apart < least) least = apart, out = i;
  }
  pictures_.erase(pictures_.begin() + static_cast<std::ptrdiff_t>(out));
}

}  // namespace kasumi
