#include "estimator/sky_camera/sun_in_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "estimator/turbidity/sky_samples.hpp"

namespace kasumi {

namespace {

constexpr int kFewElements = 6;    // a blob of no more has no meaningful shape
constexpr double kRimReach = 0.6;  // of the saturated level: lower edge of the blob's soft rim

float dimmest(const glm::vec3& encoded) {
  return std::min({encoded.r, encoded.g, encoded.b});
}

// The share of an element that the blob covers, from its level: 1 where saturated, less on the rim.
double cover_of(const glm::vec3& encoded, double saturated) {
  return std::clamp((static_cast<double>(dimmest(encoded)) / saturated - kRimReach) / (1.0 - kRimReach), 0.0, 1.0);
}

struct Box {
  int left, top, right, bottom;  // inclusive
};

struct Shape {
  glm::dvec3 direction{0.0};
  double solid_angle = 0.0;
  double roundness = 1.0;  // smaller over larger axis
};

// Centre and axes on the sphere, rim included.
Shape shape_of(const SkyPicture& picture, const SkyGeometry& geometry, const cv::Mat1i& labels, int label,
               const Box& box, double saturated) {
  constexpr int kMargin = 2;
  struct Part {
    glm::dvec3 direction;
    double weight;
  };
  std::vector<Part> parts;
  Shape shape;
  int elements = 0;
  for (int y = std::max(0, box.top - kMargin); y <= std::min(labels.rows - 1, box.bottom + kMargin); ++y)
    for (int x = std::max(0, box.left - kMargin); x <= std::min(labels.cols - 1, box.right + kMargin); ++x) {
      const int here = labels(y, x);
      if (geometry.solid_angle.at(x, y) <= 0.0f || (here != 0 && here != label)) continue;
      const double weight =
          cover_of(picture.encoded.at(x, y), saturated) * static_cast<double>(geometry.solid_angle.at(x, y));
      if (weight <= 0.0) continue;
      if (here == label) {
        ++elements;
        shape.solid_angle += static_cast<double>(geometry.solid_angle.at(x, y));
      }
      parts.push_back({glm::dvec3(geometry.direction.at(x, y)), weight});
      shape.direction += weight * parts.back().direction;
    }
  shape.direction = glm::normalize(shape.direction);
  if (elements <= kFewElements) return shape;
  const glm::dvec3 pole = std::abs(shape.direction.z) < 0.9 ? glm::dvec3{0.0, 0.0, 1.0} : glm::dvec3{1.0, 0.0, 0.0};
  const glm::dvec3 a = glm::normalize(glm::cross(shape.direction, pole)), b = glm::cross(shape.direction, a);
  double aa = 0.0, ab = 0.0, bb = 0.0;
  for (const Part& part : parts) {
    const double u = glm::dot(part.direction, a), v = glm::dot(part.direction, b);
    aa += part.weight * u * u;
    ab += part.weight * u * v;
    bb += part.weight * v * v;
  }
  const double mean = 0.5 * (aa + bb), half = std::hypot(0.5 * (aa - bb), ab);
  shape.roundness = std::sqrt(std::max(0.0, mean - half) / (mean + half));
  return shape;
}

// How much brighter the sky is close around the blob than further away, in encoded levels: the sun has an aureole, a
// reflection on the dome or in a window has none. 0..1.
double aureole_of(const SkyPicture& picture, const SkyGeometry& geometry, const glm::dvec3& centre, double radius,
                  double resolution) {
  const glm::vec3 towards(centre);
  const auto cosine = [](double angle) { return static_cast<float>(std::cos(angle)); };
  const double rim = radius + 2.5 * resolution;
  const float inner = cosine(rim), outer = cosine(rim + from_degrees(6.0).value);
  const float far_inner = cosine(rim + from_degrees(25.0).value), far_outer = cosine(rim + from_degrees(40.0).value);
  std::array<double, 2> sum{}, weight{};
  for (int y = 0; y < picture.encoded.height(); ++y)
    for (int x = 0; x < picture.encoded.width(); ++x) {
      if (geometry.open.at(x, y) == 0) continue;
      const float c = glm::dot(geometry.direction.at(x, y), towards);
      const bool near = c < inner && c > outer, far = c < far_inner && c > far_outer;
      if (!near && !far) continue;
      const std::size_t ring = near ? 0 : 1;
      const auto angle = static_cast<double>(geometry.solid_angle.at(x, y));
      const glm::vec3& e = picture.encoded.at(x, y);
      sum[ring] += angle * static_cast<double>(e.r + e.g + e.b) / 3.0;
      weight[ring] += angle;
    }
  if (weight[0] <= 0.0 || weight[1] <= 0.0) return 0.0;
  const double close = sum[0] / weight[0], away = sum[1] / weight[1];
  return std::clamp((close / std::max(1e-3, away) - 1.0) / 0.3, 0.0, 1.0);
}

}  // namespace

std::optional<SunBlob> find_sun(const SkyPicture& picture, const Camera& camera, const SunBlobOptions& options) {
  if (picture.encoded.empty()) return std::nullopt;
  const SkyGeometry geometry = sky_geometry(camera, picture);
  cv::Mat1b saturated(picture.encoded.height(), picture.encoded.width(), std::uint8_t{0});
  for (int y = 0; y < saturated.rows; ++y)
    for (int x = 0; x < saturated.cols; ++x)
      if (geometry.open.at(x, y) != 0 && static_cast<double>(dimmest(picture.encoded.at(x, y))) >= options.saturated)
        saturated(y, x) = 1;
  cv::Mat1i labels;
  cv::Mat1i stats;
  cv::Mat1d centroids;
  const int count = cv::connectedComponentsWithStats(saturated, labels, stats, centroids, 8, CV_32S);

  std::optional<SunBlob> best;
  double runner_up = 0.0;
  for (int label = 1; label < count; ++label) {
    const Box box{stats(label, cv::CC_STAT_LEFT), stats(label, cv::CC_STAT_TOP),
                  stats(label, cv::CC_STAT_LEFT) + stats(label, cv::CC_STAT_WIDTH) - 1,
                  stats(label, cv::CC_STAT_TOP) + stats(label, cv::CC_STAT_HEIGHT) - 1};
    const Shape shape = shape_of(picture, geometry, labels, label, box, options.saturated);
    const double radius = std::sqrt(shape.solid_angle / kPi);
    if (radius < options.smallest_radius.value || radius > options.largest_radius.value) continue;
    const double resolution = std::sqrt(shape.solid_angle / stats(label, cv::CC_STAT_AREA));
    // A wide blob is more likely a white cloud.
    const double size = std::clamp(1.5 * (1.0 - radius / options.largest_radius.value), 0.0, 1.0);
    const double score = shape.roundness * shape.roundness * size *
                         (0.25 + 0.75 * aureole_of(picture, geometry, shape.direction, radius, resolution));
    if (best && score <= best->confidence) {
      runner_up = std::max(runner_up, score);
      continue;
    }
    if (best) runner_up = best->confidence;
    const auto pixel = camera.pixel_of(shape.direction);
    if (!pixel) continue;
    best = SunBlob{shape.direction, *pixel, {radius}, score};
  }
  if (!best) return std::nullopt;
  best->confidence *= 1.0 - 0.5 * runner_up / best->confidence;
  return best->confidence >= options.least_confidence ? best : std::nullopt;
}

SunCheck cross_check(const std::optional<SunDirection>& ephemeris, const std::optional<SunBlob>& blob,
                     bool clock_trusted, Radians tolerance) {
  SunCheck check;
  if (ephemeris && blob) {
    check.disagreement = angle_between(*ephemeris, blob->direction);
    check.agrees = *check.disagreement <= tolerance;
  }
  if (ephemeris && clock_trusted) {
    check.source = SunSource::ephemeris;
    check.direction = *ephemeris;
  } else if (blob) {
    check.source = SunSource::image;
    check.direction = blob->direction;
  }
  const std::string apart = check.disagreement ? fmt::format("the sun in the image is {:.1f} deg from the ephemeris",
                                                             to_degrees(*check.disagreement))
                            : blob             ? std::string("there is no ephemeris to compare with")
                                               : std::string("no sun is seen in the image");
  switch (check.source) {
    case SunSource::ephemeris:
      check.message = check.disagreement && !check.agrees
                          ? apart + "; the clock is trusted, so check the camera's orientation"
                          : apart;
      break;
    case SunSource::image:
      check.message = apart + (clock_trusted ? "" : "; the clock is not trusted, so the sun in the image is used");
      break;
    case SunSource::none:
      check.message = apart + ", and the clock is not trusted: the sun's direction is unknown";
      break;
  }
  return check;
}

}  // namespace kasumi
