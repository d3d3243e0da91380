#include "estimator/passers/expected_scene.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

namespace kasumi {
namespace {

constexpr std::size_t kEnough = 12;  // pictures
// Between remembered pictures: while the scene is learnt, while the light is new, and while it stays. Shorter fills the
// memory with one light, longer misses a cloud's passing.
constexpr Duration kOften = std::chrono::seconds(10), kSoon = std::chrono::seconds(4),
                   kSeldom = std::chrono::seconds(20);
constexpr float kNoise = 0.8F, kRelative = 0.012F;  // of a cell's luma
constexpr float kColourNoise = 0.7F;  // of a cell's chroma; a camera averages chroma over twice the pixels
constexpr float kOther = 3.0F, kMoved = 5.0F, kOfLate_s = 10.0F;  // a cell's own standard deviations
// Short of full scale by what noise and sharpening take; above, light is unknown.
constexpr float kBurnt = 248.0F;
// Time constants. Longer keeps passers out of what counts as usual, shorter follows new light.
constexpr float kSpreadFollows_s = 120.0F, kOffFollows_s = 40.0F;

glm::mat3 to_rgb(const YuvToRgb& conversion) {
  return glm::transpose(glm::mat3(conversion.rows[0], conversion.rows[1], conversion.rows[2]));
}

bool near_any_of(const Image<std::uint8_t>& mask, int column, int row, int reach) {
  for (int y = std::max(0, row - reach); y <= std::min(mask.height() - 1, row + reach); ++y)
    for (int x = std::max(0, column - reach); x <= std::min(mask.width() - 1, column + reach); ++x)
      if (mask.at(x, y)) return true;
  return false;
}

}  // namespace

ExpectedScene::ExpectedScene(const PartPlace& place, const Tone& tone)
    : place_(place),
      tone_(tone),
      cells_(place.columns(), place.rows()),
      light_(cells_.width(), cells_.height()),
      expected_(cells_.width(), cells_.height(), glm::vec3{0}),
      rest_(cells_.width(), cells_.height(), glm::vec3{0}),
      sigma_(cells_.width(), cells_.height(), 1.0F),
      score_(cells_.width(), cells_.height(), -1.0F),
      luma_(place.width, place.height, 0.0F),
      colour_(place.width / 2, place.height / 2, glm::vec2{0}),
      made_(cells_.width(), cells_.height(), 0) {}

bool ExpectedScene::known() const {
  return memory_.pictures().size() >= kEnough;
}

double ExpectedScene::known_share() const {
  return std::min(1.0, static_cast<double>(memory_.pictures().size()) / static_cast<double>(kEnough));
}

Duration ExpectedScene::until_known() const {
  const std::size_t has = memory_.pictures().size();
  return has >= kEnough ? Duration::zero() : static_cast<int>(kEnough - has) * kOften;
}

const Image<float>& ExpectedScene::compare(const PicturePart& picture, Duration since) {
  const auto seconds = static_cast<float>(to_seconds(since));
  ++turn_;
  const YuvToRgb conversion = yuv_to_rgb(picture.encoding());
  const auto& now = picture.cells();
  std::vector<float> lumas;
  for (int y = 0; y < now.height(); ++y)
    for (int x = 0; x < now.width(); ++x) {
      light_.at(x, y) = light_of_cell(now.at(x, y), conversion, tone_);
      if ((x + y) % 2 == 0) lumas.push_back(now.at(x, y).x);
      const Cell& cell = cells_.at(x, y);
      const float relative = kRelative * now.at(x, y).x;
      const bool burnt = now.at(x, y).x > kBurnt;
      sigma_.at(x, y) =
          burnt ? 0.0F : std::sqrt(kNoise * kNoise + relative * relative + cell.variance.x + cell.variance.y);
    }
  if (!lumas.empty()) {
    const auto middle = lumas.begin() + static_cast<std::ptrdiff_t>(lumas.size() / 2);
    std::nth_element(lumas.begin(), middle, lumas.end());
    median_luma_ = static_cast<double>(*middle);
  }
  if (mix_.empty()) return score_;
  mix_.explain(light_, sigma_);
  const glm::mat3 to_yuv = glm::inverse(to_rgb(conversion));
  const glm::vec3 offset = 255.0F * conversion.offset - glm::vec3{0.0F, 128.0F, 128.0F};
  for (int y = 0; y < now.height(); ++y)
    for (int x = 0; x < now.width(); ++x) {
      Cell& cell = cells_.at(x, y);
      expected_.at(x, y) = to_yuv * tone_.to_code(mix_.expected().at(x, y)) + offset + cell.off;
      const glm::vec3 rest = rest_.at(x, y) = now.at(x, y) - expected_.at(x, y);
      const float relative = kRelative * now.at(x, y).x;
      const float luma2 = kNoise * kNoise + relative * relative + cell.variance.x;
      const float colour2 = kColourNoise * kColourNoise + cell.variance.y;
      const glm::vec3 difference = rest / glm::sqrt(glm::vec3{luma2, colour2, colour2});
      score_.at(x, y) = glm::length(difference);
      if (score_.at(x, y) < kOther || glm::length(difference - cell.of_late) > kMoved) {
        cell.still_s = 0.0F;
        cell.of_late = difference;
      } else {
        cell.still_s += seconds;
        cell.of_late += std::min(0.3F, seconds / kOfLate_s) * (difference - cell.of_late);
      }
    }
  return score_;
}

void ExpectedScene::expect_pixels(const Image<std::uint8_t>& cells) {
  if (mix_.empty()) return;
  for (int y = 0; y < cells.height(); ++y)
    for (int x = 0; x < cells.width(); ++x) {
      if (!cells.at(x, y)) continue;
      for (int v = std::max(0, y - kMargin); v <= std::min(cells.height() - 1, y + kMargin); ++v)
        for (int u = std::max(0, x - kMargin); u <= std::min(cells.width() - 1, x + kMargin); ++u) make_pixels(u, v);
    }
}

// The same mixture of the remembered pictures' pixels, whose mean is what is expected of their cell.
void ExpectedScene::make_pixels(int column, int row) {
  if (made_.at(column, row) == turn_) return;
  const auto shares = mix_.shares(column, row);
  const auto& pictures = memory_.pictures();
  if (shares.size() != pictures.size()) return;  // another was remembered since compare()
  made_.at(column, row) = turn_;
  const int side = place_.cell_px, half = side / 2;
  const auto pixels = static_cast<float>(side * side);
  const auto count = static_cast<std::size_t>(side * side);
  light_sums_.assign(count, 0.0F);
  colour_sums_.assign(count / 4, glm::vec2{0});
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const float share = shares[i];
    float* light = light_sums_.data();
    for (int y = row * side; y < (row + 1) * side; ++y) {
      const std::uint8_t* luma = pictures[i].luma.row(y) + column * side;
      for (int x = 0; x < side; ++x) *light++ += share * tone_.luma_to_light(luma[x]);
    }
    glm::vec2* colour = colour_sums_.data();
    for (int y = row * half; y < (row + 1) * half; ++y) {
      const std::uint8_t *blue = pictures[i].blue.row(y) + column * half, *red = pictures[i].red.row(y) + column * half;
      for (int x = 0; x < half; ++x) *colour++ += share * glm::vec2{blue[x] - 128.0F, red[x] - 128.0F};
    }
  }
  float mean = 0.0F;
  const float* light = light_sums_.data();
  for (int y = row * side; y < (row + 1) * side; ++y)
    for (int x = column * side; x < (column + 1) * side; ++x) {
      luma_.at(x, y) = tone_.luma_to_code(*light++);
      mean += luma_.at(x, y) / pixels;
    }
  glm::vec2 mean_colour{0};
  const glm::vec2* colour = colour_sums_.data();
  for (int y = row * half; y < (row + 1) * half; ++y)
    for (int x = column * half; x < (column + 1) * half; ++x) {
      colour_.at(x, y) = *colour;
      mean_colour += 4.0F * *colour++ / pixels;
    }
  const glm::vec3& is = expected_.at(column, row);
  for (int y = row * side; y < (row + 1) * side; ++y)
    for (int x = column * side; x < (column + 1) * side; ++x) luma_.at(x, y) += is.x - mean;
  for (int y = row * half; y < (row + 1) * half; ++y)
    for (int x = column * half; x < (column + 1) * half; ++x)
      colour_.at(x, y) += glm::vec2{is.y, is.z} - mean_colour + 128.0F;
}

glm::vec3 ExpectedScene::pixel(int x, int y) const {
  return {luma_.at(x, y), colour_.at(x / 2, y / 2)};
}

void ExpectedScene::measure_noise(const PicturePart& picture, const Image<std::uint8_t>& in_front) {
  const int side = place_.cell_px;
  float misses2 = 0.0F, squares = 0.0F;
  int count = 0;
  // Some cells, others in each picture.
  for (std::size_t i = turn_ % 61; i < cells_.elements().size(); i += 61) {
    const int column = static_cast<int>(i) % cells_.width(), row = static_cast<int>(i) / cells_.width();
    if (near_any_of(in_front, column, row, 2)) continue;
    make_pixels(column, row);
    float miss = 0.0F, square = 0.0F;
    for (int y = row * side; y < row * side + 3; ++y)
      for (int x = column * side; x < column * side + 3; ++x) {
        const float off = static_cast<float>(picture.luma().at(x, y)) - luma_.at(x, y);
        miss += off;
        square += off * off;
      }
    misses2 += std::min(miss * miss / 81.0F, 100.0F);
    squares += std::min(square / 9.0F, 200.0F);
    ++count;
  }
  if (count < 10) return;
  detail_noise_ += 0.05 * (std::sqrt(static_cast<double>(misses2) / count) - detail_noise_);
  pixel_noise_ += 0.05 * (std::sqrt(static_cast<double>(squares) / count) - pixel_noise_);
}

void ExpectedScene::learn(const PicturePart& picture, const Image<std::uint8_t>& in_front, Instant at, Duration since,
                          bool settled) {
  const auto seconds = static_cast<float>(to_seconds(since));
  const float spread_share = std::min(0.2F, seconds / kSpreadFollows_s),
              off_share = std::min(0.2F, seconds / kOffFollows_s);
  const bool is_known = !mix_.empty();
  for (int y = 0; y < cells_.height(); ++y)
    for (int x = 0; x < cells_.width(); ++x) {
      Cell& cell = cells_.at(x, y);
      if (in_front.at(x, y))
        cell.covered_s += seconds;
      else
        cell.covered_s = std::max(0.0F, cell.covered_s - 4.0F * seconds);
      if (!is_known || !settled || near_any_of(in_front, x, y, 1)) continue;
      const glm::vec3& rest = rest_.at(x, y);
      const auto spread = [&](float& variance, float miss2, float least) {
        variance += spread_share * (std::min(miss2, 9.0F * (variance + least)) - variance);
      };
      spread(cell.variance.x, rest.x * rest.x, kNoise * kNoise);
      spread(cell.variance.y, 0.5F * (rest.y * rest.y + rest.z * rest.z), kColourNoise * kColourNoise);
      cell.off += off_share * rest;
    }
  if (is_known && settled) measure_noise(picture, in_front);
  if (!memory_.wants(at)) return;
  const int side = place_.cell_px;
  RememberedFrame now{at, picture.luma(), picture.blue(), picture.red(), {}};
  if (settled && is_known)
    for (int row = 0; row < cells_.height(); ++row)
      for (int column = 0; column < cells_.width(); ++column) {
        if (made_.at(column, row) != turn_ || !near_any_of(in_front, column, row, 2)) continue;
        if (cells_.at(column, row).covered_s > std::chrono::duration<float>(kUnchanged).count()) continue;
        const auto byte = [](float value) { return static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F)); };
        for (int y = row * side; y < (row + 1) * side; ++y)
          for (int x = column * side; x < (column + 1) * side; ++x) {
            const glm::vec3 is = pixel(x, y);
            now.luma.at(x, y) = byte(is.x);
            now.blue.at(x / 2, y / 2) = byte(is.y);
            now.red.at(x / 2, y / 2) = byte(is.z);
          }
      }
  const Duration apart = !known() ? kOften : settled ? kSeldom : kSoon;
  if (memory_.add(std::move(now), apart, picture, tone_) && known()) mix_.learn(memory_.pictures(), tone_);
}

}  // namespace kasumi
