#include "estimator/haze/range.hpp"

#include <algorithm>
#include <cmath>

#include <glm/vec2.hpp>
#include <opencv2/imgproc.hpp>

#include "estimator/haze/outlines.hpp"

namespace kasumi {
namespace {

Result<> check(const RangeRules& options) {
  Problems problems;
  if (!(options.smallest_sky_share > 0.0 && options.smallest_sky_share <= 1.0))
    problems.add("smallest share of the sky {}: expected more than 0, at most 1", options.smallest_sky_share);
  if (!(options.sky_range > 1.0 && options.sky_range <= 10.0))
    problems.add("range of the sky {}: expected more than 1, at most 10", options.sky_range);
  if (options.margin_px < 0 || options.margin_px > 200)
    problems.add("margin of {} px: expected 0 to 200", options.margin_px);
  if (options.outline_reach_px < 0 || options.outline_reach_px > 64)
    problems.add("reach of outlines {} px: expected 0 to 64", options.outline_reach_px);
  if (!problems.empty()) return fail(problems.fault());
  return {};
}

// H needs about 2 mu Jacobi steps. With over-relaxation (Young 1954) the same number reaches a hundredth of their
// error.
int sweeps_for(int margin_px) {
  return 4 * margin_px + 8;
}
double over_relaxation(int margin_px) {
  return 2.0 / (1.0 + std::sin(3.141592653589793 / (margin_px + 1.0)));
}

}  // namespace

Result<HazeRange> prepare_range(const Image<float>& range_m, const RangeRules& options,
                                const Image<glm::vec3>& picture) {
  if (auto fine = check(options); !fine) return fail(fine.error());
  if (options.outline_reach_px > 0 && (picture.width() != range_m.width() || picture.height() != range_m.height()))
    return fail(FaultKind::bad_input, "a picture of {} x {}: expected {} x {}, the size of the range map",
                picture.width(), picture.height(), range_m.width(), range_m.height());
  const int width = range_m.width(), height = range_m.height();
  HazeRange made;
  const bool has_sky = options.smallest_sky_share < 1.0;
  for (const float range : range_m.elements())
    if (std::isfinite(range)) made.farthest_m = std::max(made.farthest_m, static_cast<double>(range));
  if (!(made.farthest_m > 0.0))
    return fail(FaultKind::bad_input, "the range map holds no measured range: expected metres > 0");
  made.range = range_m;
  int told_sky_pixels = 0;
  for (float& range : made.range.elements()) {
    if (std::isinf(range) && has_sky) ++told_sky_pixels;
    range = std::isfinite(range) ? range / static_cast<float>(made.farthest_m) : 0.0F;
  }

  Image<std::uint8_t> undefined(width, height);
  std::ranges::transform(range_m.elements(), undefined.elements().begin(), [&](float range) -> std::uint8_t {
    return range > 0.0F && (has_sky || std::isfinite(range)) ? 0 : 255;
  });
  Image<int> labels(width, height);
  cv::Mat label_map(height, width, CV_32S, labels.elements().data()), stats, centres;
  const int count = cv::connectedComponentsWithStats(cv::Mat(height, width, CV_8U, undefined.elements().data()),
                                                     label_map, stats, centres, 8, CV_32S);
  const double pixels = static_cast<double>(width) * height;
  std::vector<int> hole_number(static_cast<std::size_t>(count), 0);  // 0: sky, or measured
  int hole_pixels = 0, sky_pixels = 0;
  for (int i = 1; i < count; ++i) {
    const int area = stats.at<int>(i, cv::CC_STAT_AREA);
    const bool is_sky = has_sky && area >= options.smallest_sky_share * pixels;
    (is_sky ? sky_pixels : hole_pixels) += area;
    if (!is_sky) hole_number[static_cast<std::size_t>(i)] = ++made.holes;
  }
  made.hole_share = hole_pixels / pixels;
  made.sky_share = (sky_pixels + told_sky_pixels) / pixels;
  made.sky = Image<std::uint8_t>(width, height);
  for (std::size_t i = 0; i < labels.elements().size(); ++i) {
    int& label = labels.elements()[i];
    const int hole = hole_number[static_cast<std::size_t>(label)];
    if ((label > 0 && hole == 0) || (has_sky && std::isinf(range_m.elements()[i]))) {
      made.sky.elements()[i] = 255;
      made.range.elements()[i] = static_cast<float>(options.sky_range);
    }
    label = hole;
  }
  fill_holes(made.range, labels, made.holes);
  if (options.outline_reach_px > 0) {
    move_outlines_to_edges(picture, made.range, options.outline_reach_px);
    for (std::size_t i = 0; i < labels.elements().size(); ++i)
      made.sky.elements()[i] = made.range.elements()[i] > 1.0F ? 255 : 0;
  }
  // Computed before the margin hides where the scene ends.
  made.steps_along_row = range_steps_along_row(made.range);
  made.steps_down_column = range_steps_down_column(made.range);
  taper_into_sky(made.range, made.sky, static_cast<float>(options.sky_range), options.margin_px);
  return made;
}

// At the edge of foliage neither picture nor range is reliable, and a hard edge of the haze would show, so the range
// blends smoothly into the sky's there. Measured values stay unchanged.
void taper_into_sky(Image<float>& range, const Image<std::uint8_t>& sky, float sky_range, int margin_px) {
  if (margin_px < 1 || range.empty()) return;
  auto copy = sky.elements();
  cv::Mat distance;
  cv::distanceTransform(cv::Mat(sky.height(), sky.width(), CV_8U, copy.data()), distance, cv::DIST_L2,
                        cv::DIST_MASK_PRECISE);
  std::vector<glm::ivec2> margin;
  for (int y = 0; y < sky.height(); ++y)
    for (int x = 0; x < sky.width(); ++x)
      if (sky.at(x, y) != 0 && distance.at<float>(y, x) < static_cast<float>(margin_px)) {
        margin.push_back({x, y});
        range.at(x, y) = sky_range;
      }
  const auto relax = static_cast<float>(over_relaxation(margin_px));
  for (int sweep = 0; sweep < sweeps_for(margin_px); ++sweep)
    for (const auto& p : margin) {
      float sum = 0.0F, count = 0.0F;
      for (const glm::ivec2 u : {glm::ivec2{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
        if (range.contains(p.x + u.x, p.y + u.y)) {
          sum += range.at(p.x + u.x, p.y + u.y);
          count += 1.0F;
        }
      float& here = range.at(p.x, p.y);
      here += relax * (sum / count - here);
    }
}

}  // namespace kasumi
