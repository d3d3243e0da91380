#include "estimator/sky_camera/bright_blobs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <glm/geometric.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "base/square.hpp"
#include "base/statistics.hpp"

namespace kasumi {

namespace {

constexpr double kLeastTop = 0.35;              // encoded: a sky that is darker everywhere shows no sun
constexpr std::size_t kElementsOfTop = 5;       // fewer may be hot pixels
constexpr std::array kLevels{0.985, 0.945};     // of the top
constexpr int kPeaks = 3;                       // of each level
constexpr Radians kLowest = from_degrees(2.0);  // elevation: below are the rim's fringes
// A dark spot within a core, such as a wire or a clipped channel, still belongs to it.
constexpr Radians kLargestHole = from_degrees(2.0);

bool shows_sky(const Camera& camera, const SunDirection& direction, const glm::dvec2& pixel) {
  if (direction.z < std::sin(kLowest.value)) return false;
  if (camera.mask.empty()) return true;
  const int x = static_cast<int>(std::lround(pixel.x)), y = static_cast<int>(std::lround(pixel.y));
  return camera.mask.contains(x, y) && camera.mask.at(x, y) != 0;
}

float level_of(const glm::vec3& encoded) {
  return std::min({encoded.r, encoded.g, encoded.b});
}

struct Levels {
  cv::Mat1f bright;  // encoded; 0 where it is dark or no sky
  double top = 0.0;
  double middle = 0.0;
};

Levels levels_of(const SkyPicture& picture, const Camera& camera) {
  constexpr int kGrid = 5;  // the median needs only some elements
  const auto& encoded = picture.encoded;
  Levels levels{cv::Mat1f(encoded.height(), encoded.width(), 0.0f)};
  std::vector<float> all, some;
  for (int y = 0; y < encoded.height(); ++y)
    for (int x = 0; x < encoded.width(); ++x) {
      const float level = level_of(encoded.at(x, y));
      const bool on_grid = x % kGrid == 0 && y % kGrid == 0;
      if (level < static_cast<float>(0.5 * kLeastTop) && !on_grid) continue;
      const glm::dvec2 pixel = picture.camera_pixel(x, y);
      const auto direction = camera.direction_at(pixel);
      if (!direction || !shows_sky(camera, *direction, pixel)) continue;
      levels.bright(y, x) = level;
      all.push_back(level);
      if (on_grid) some.push_back(level);
    }
  if (all.size() < kElementsOfTop || some.empty()) return levels;
  const auto last = all.begin() + static_cast<std::ptrdiff_t>(kElementsOfTop) - 1;
  std::ranges::nth_element(all, last, std::ranges::greater{});
  levels.top = static_cast<double>(*last);
  levels.middle = static_cast<double>(median_in_place(some)) / std::max(levels.top, 1e-6);
  return levels;
}

// Some sensors show the sun's disc black in the middle of its glare.
void fill_holes(cv::Mat1b& mask, double largest_area) {
  cv::Mat1i labels, stats;
  cv::Mat1d centroids;
  cv::connectedComponentsWithStats(~mask, labels, stats, centroids, 4, CV_32S);
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x)
      if (mask(y, x) == 0 && stats(labels(y, x), cv::CC_STAT_AREA) <= largest_area) mask(y, x) = 255;
}

struct Core {
  glm::dvec2 middle{};  // element
  double radius = 0.0;  // elements
};

// How far inside of what is as bright as a level each element lies.
class Inside {
 public:
  Inside(const cv::Mat1f& bright, double level, double largest_hole) {
    cv::Mat1b mask;
    cv::compare(bright, level, mask, cv::CMP_GE);
    area_ = cv::countNonZero(mask);
    cv::copyMakeBorder(mask, mask, 1, 1, 1, 1, cv::BORDER_CONSTANT, 0);
    fill_holes(mask, largest_hole);
    cv::distanceTransform(mask, distance_, cv::DIST_L2, cv::DIST_MASK_5);
    distance_ = distance_(cv::Rect(1, 1, bright.cols, bright.rows));
  }
  int area() const { return area_; }

  // The largest circle near a place, moved to the middle of what lies at least half as far inside: streaks and the edges
  // of clouds that touch the sun are thinner than that.
  std::optional<Core> core(const cv::Point& around, double within) const {
    const cv::Rect window = square_of(around, within);
    if (window.empty()) return std::nullopt;
    double radius = 0.0;
    cv::Point peak;
    cv::minMaxLoc(distance_(window), nullptr, &radius, nullptr, &peak);
    if (radius <= 0.0) return std::nullopt;
    peak += window.tl();
    const cv::Rect wide = square_of(peak, 3.0 * radius + 1.0);
    cv::Mat1b inner;
    cv::compare(distance_(wide), 0.5 * radius, inner, cv::CMP_GE);
    cv::Mat1i labels;
    cv::connectedComponents(inner, labels, 8, CV_32S);
    const cv::Moments moments = cv::moments(labels == labels(peak - wide.tl()), true);
    return Core{{wide.x + moments.m10 / moments.m00, wide.y + moments.m01 / moments.m00}, radius};
  }
  std::vector<Core> largest(int most) const {
    cv::Mat1f left = distance_.clone();
    std::vector<Core> cores;
    for (int n = 0; n < most; ++n) {
      double radius = 0.0;
      cv::Point peak;
      cv::minMaxLoc(left, nullptr, &radius, nullptr, &peak);
      if (radius <= 0.0) break;
      if (const auto found = core(peak, 0.0)) cores.push_back(*found);
      cv::circle(left, peak, static_cast<int>(2.0 * radius) + 2, cv::Scalar(0.0), cv::FILLED);
    }
    return cores;
  }

 private:
  cv::Rect square_of(const cv::Point& middle, double half) const {
    const int h = static_cast<int>(half);
    return cv::Rect(middle.x - h, middle.y - h, 2 * h + 1, 2 * h + 1) & cv::Rect(0, 0, distance_.cols, distance_.rows);
  }
  cv::Mat1f distance_;
  int area_ = 0;
};

// Encoded levels of the sky at a distance from a direction, and where they are: the cosine of the turn from the way up.
struct Ring {
  std::vector<double> level, upwards;

  double mean() const {
    double sum = 0.0;
    for (const double l : level) sum += l / static_cast<double>(level.size());
    return sum;
  }
  // How much brighter it is above than beside.
  double brighter_above() const {
    double sum = 0.0, weight = 0.0;
    for (std::size_t i = 0; i < level.size(); ++i) {
      sum += upwards[i] * (level[i] - mean());
      weight += square(upwards[i]);
    }
    return weight > 0.0 ? sum / weight : 0.0;
  }
};

constexpr int kRays = 32;  // 11 deg apart around a blob

Ring ring_around(const SkyPicture& picture, const Camera& camera, const SunDirection& middle, double distance) {
  const glm::dvec3 pole = std::abs(middle.z) < 0.999 ? glm::dvec3{0.0, 0.0, 1.0} : glm::dvec3{1.0, 0.0, 0.0};
  const glm::dvec3 aside = glm::normalize(glm::cross(pole, middle)), up = glm::cross(middle, aside);
  Ring ring;
  for (int k = 0; k < kRays; ++k) {
    const double turn = 2.0 * kPi * k / kRays;
    const SunDirection direction =
        std::cos(distance) * middle + std::sin(distance) * (std::cos(turn) * up + std::sin(turn) * aside);
    const auto pixel = camera.pixel_of(direction);
    if (!pixel || !shows_sky(camera, direction, *pixel)) continue;
    const glm::dvec2 place = (*pixel - picture.first) / picture.step;
    const int x = static_cast<int>(std::lround(place.x)), y = static_cast<int>(std::lround(place.y));
    if (!picture.encoded.contains(x, y)) continue;
    ring.level.push_back(static_cast<double>(level_of(picture.encoded.at(x, y))));
    ring.upwards.push_back(std::cos(turn));
  }
  return ring;
}

// A sky that is brighter towards the horizon moves an isophote of the sun's surroundings that way: by its slope over
// their fall, which is seen above and beside it. Empty where too little of the surroundings is sky, or does not fall.
std::optional<Radians> lowered_by_sky(const SkyPicture& picture, const Camera& camera, const BrightBlob& blob) {
  // Distances of the two rings from the rim: outside the lens's blur, and near enough to see the aureole fall.
  constexpr Radians kNear = from_degrees(1.0), kFar = from_degrees(3.0);
  // A middle is never moved out of its blob; of a ring all counts as seen but its lowest third, where land may be.
  constexpr double kMostOfRadius = 0.8, kBelow = -0.5;
  const auto seen_above = [](const Ring& ring) {
    return std::ranges::count_if(ring.upwards, [](double upwards) { return upwards > kBelow; }) >= 2 * kRays / 3;
  };
  const auto above = [](const Ring& ring) {
    double sum = 0.0, count = 0.0;
    for (std::size_t i = 0; i < ring.level.size(); ++i)
      if (ring.upwards[i] > 0.0) sum += ring.level[i], count += 1.0;
    return sum / std::max(count, 1.0);
  };
  const double near = blob.radius.value + kNear.value;
  const Ring inner = ring_around(picture, camera, blob.direction, near);
  const Ring outer = ring_around(picture, camera, blob.direction, blob.radius.value + kFar.value);
  if (!seen_above(inner) || !seen_above(outer)) return std::nullopt;
  const double fall = (above(inner) - above(outer)) / (kFar - kNear).value;
  const double slope = -inner.brighter_above() / near;
  if (fall <= 0.0) return std::nullopt;
  if (slope <= 0.0) return Radians{0.0};
  return Radians{std::min(slope * blob.radius.value / fall, kMostOfRadius * blob.radius.value)};
}

// Elements per radian at the zenith.
double scale_of(const SkyPicture& picture, const Camera& camera) {
  // Far enough for a mean scale, near enough to hold at the zenith.
  constexpr Radians kAside = from_degrees(10.0);
  const auto up = camera.pixel_of({0.0, 0.0, 1.0}), aside = camera.pixel_of(direction_from(kAside, {0.0}));
  return up && aside ? glm::distance(*up, *aside) / picture.step / kAside.value : 0.0;
}

// A core as it is seen on the sphere.
std::optional<BrightBlob> blob_at(const SkyPicture& picture, const Camera& camera, const Core& core, double apart,
                                  double top) {
  const auto direction_at = [&](double x, double y) { return camera.direction_at(picture.camera_pixel(x, y)); };
  const auto direction = direction_at(core.middle.x, core.middle.y);
  const auto right = direction_at(core.middle.x + 1.0, core.middle.y);
  const auto below = direction_at(core.middle.x, core.middle.y + 1.0);
  if (!direction || !right || !below) return std::nullopt;
  BrightBlob blob;
  blob.direction = *direction;
  blob.resolution = Radians{std::sqrt(glm::length(glm::cross(*right - *direction, *below - *direction)))};
  blob.radius = core.radius * blob.resolution;
  blob.scatter = apart * blob.resolution;
  const auto ring = ring_around(picture, camera, *direction, blob.radius.value + from_degrees(5.0).value);
  blob.around = median(ring.level) / top;
  blob.spread = (quantile(ring.level, 0.75) - quantile(ring.level, 0.25)) / top;
  blob.lowered = lowered_by_sky(picture, camera, blob);
  return blob;
}

}  // namespace

BrightBlobs bright_sky(const SkyPicture& picture, const Camera& camera, double saturated) {
  BrightBlobs sky;
  if (picture.encoded.empty()) return sky;
  const Levels levels = levels_of(picture, camera);
  sky.middle = levels.middle;
  if (levels.top < kLeastTop) return sky;
  const double top = std::min(levels.top, saturated / kLevels[0]);
  const double hole = kPi * square(kLargestHole.value * scale_of(picture, camera));
  const std::array inside{Inside(levels.bright, kLevels[0] * top, hole), Inside(levels.bright, kLevels[1] * top, hole)};
  std::vector<Core> known;
  for (const bool upper : {true, false})
    for (Core core : inside[upper ? 0 : 1].largest(kPeaks)) {
      const bool seen = std::ranges::any_of(known, [&](const Core& k) {
        return glm::distance(k.middle, core.middle) < std::max(k.radius, core.radius) + 1.0;
      });
      if (seen) continue;
      known.push_back(core);
      double apart = 0.0;
      const cv::Point at(static_cast<int>(std::lround(core.middle.x)), static_cast<int>(std::lround(core.middle.y)));
      if (const auto lower = upper ? inside[1].core(at, core.radius) : std::nullopt) {
        apart = glm::distance(lower->middle, core.middle);
        // Farther off, the lower level has joined the sun to a cloud.
        if (apart < core.radius) core.middle = 0.5 * (core.middle + lower->middle);
      }
      auto blob = blob_at(picture, camera, core, apart, top);
      if (!blob) continue;
      blob->share = kPi * square(core.radius) / std::max(1, inside[upper ? 0 : 1].area());
      sky.blobs.push_back(*blob);
    }
  return sky;
}

}  // namespace kasumi
