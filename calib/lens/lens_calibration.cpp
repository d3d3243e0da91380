#include "calib/lens/lens_calibration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/ranges.h>
#include <glm/geometric.hpp>

#include "base/geometry.hpp"
#include "base/statistics.hpp"
#include "calib/board/corner_refinement.hpp"

namespace kasumi {
namespace {

constexpr double kWorseThanMedian = 3.0, kWorseBy_px = 0.3;
constexpr double kWorthMore = 0.98;  // the best model's error over that of a preferred one

// The worst view if it does not belong to the others.
std::optional<std::size_t> outlier(const LensFit& fit) {
  std::vector<double> all;
  for (const auto& view : fit.views) all.push_back(view.rms_px);
  const auto worst = static_cast<std::size_t>(std::max_element(all.begin(), all.end()) - all.begin());
  const double usual = median(all);
  if (all[worst] <= kWorseThanMedian * usual || all[worst] <= usual + kWorseBy_px) return std::nullopt;
  return worst;
}

struct CleanFit {
  LensFit fit;
  std::vector<BoardView> views;
  std::vector<DroppedView> dropped;
};

// Beyond its farthest corner a lens is a guess, but good enough for a corner's surroundings.
void locate_again(const LensDescription& lens, const BoardPose& pose, BoardView& view) {
  auto wide = lens;
  wide.largest_angle = std::min(lens.largest_angle + from_degrees(5.0), from_degrees(179.0));
  refine_corners(view, [&, model = make_lens(wide)](const glm::dvec2& on_board) {
    return model->project(pose.rotation * glm::dvec3(on_board, 0.0) + pose.translation_m);
  });
}

double mean_distance_px(const std::vector<BoardView>& one, const std::vector<BoardView>& other) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i)
    for (std::size_t k = 0; k < one[i].pixels.size(); ++k, ++count)
      sum += glm::distance(one[i].pixels[k], other[i].pixels[k]);
  return count > 0.0 ? sum / count : 0.0;
}

// Corner finders are inaccurate near a fisheye's rim, with the same error in all views, which biases the lens. Better
// corners need the lens, so lens and corners are refined in turn until they settle. Residuals do not measure this,
// since a biased lens absorbs the finder's errors, unless they grow much. Empty: it does not fit.
std::optional<LensFit> fit_and_locate(LensFamily family, std::vector<BoardView>& views, int width, int height) {
  constexpr int kMostRounds = 4;
  constexpr double kStays_px = 0.01, kMuchWorse = 1.25;
  auto fit = fit_lens(family, views, width, height);
  for (int round = 0; fit && round < kMostRounds; ++round) {
    auto again = views;
    for (std::size_t i = 0; i < again.size(); ++i) locate_again(fit->lens, fit->views[i].pose, again[i]);
    const double moved_px = mean_distance_px(again, views);
    if (moved_px == 0.0) break;
    auto better = fit_lens(family, again, width, height);
    if (!better || better->rms_px > kMuchWorse * fit->rms_px) break;
    views = std::move(again);
    fit = std::move(better);
    if (moved_px < kStays_px) break;
  }
  return fit;
}

std::optional<CleanFit> fit_without_outliers(LensFamily family, std::vector<BoardView> views, int width, int height) {
  const std::size_t fewest = std::max(kFewestViews, views.size() - views.size() / 3);
  std::vector<DroppedView> dropped;
  while (true) {
    auto fit = fit_and_locate(family, views, width, height);
    if (!fit) return std::nullopt;
    const auto worst = views.size() > fewest ? outlier(*fit) : std::nullopt;
    if (!worst) return CleanFit{std::move(*fit), std::move(views), std::move(dropped)};
    const double rms = fit->views[*worst].rms_px;
    std::vector<double> all;
    for (const auto& view : fit->views) all.push_back(view.rms_px);
    dropped.push_back(
        {views[*worst].name,
         fmt::format("its corners are {:.2f} px off (rms), the others' usually {:.2f}", rms, median(all))});
    views.erase(views.begin() + static_cast<std::ptrdiff_t>(*worst));
  }
}

// Each view is left out once; the folds are interleaved, for neighbouring pictures are alike.
std::optional<double> held_out_rms(LensFamily family, const std::vector<BoardView>& views, int width, int height,
                                   int folds) {
  const auto count = std::min(static_cast<std::size_t>(std::max(2, folds)), views.size());
  double sum = 0.0;
  std::size_t corners = 0;
  for (std::size_t fold = 0; fold < count; ++fold) {
    std::vector<BoardView> fitted;
    for (std::size_t i = 0; i < views.size(); ++i)
      if (i % count != fold) fitted.push_back(views[i]);
    const auto fit = fit_lens(family, fitted, width, height);
    if (!fit) return std::nullopt;
    for (std::size_t i = fold; i < views.size(); i += count) {
      const auto errors = residuals_of(fit->lens, views[i]);
      if (!errors) return std::nullopt;
      sum += errors->rms_px * errors->rms_px * static_cast<double>(views[i].pixels.size());
      corners += views[i].pixels.size();
    }
  }
  return std::sqrt(sum / static_cast<double>(corners));
}

std::string_view place_name(int column, int row) {
  static constexpr std::array<std::string_view, 9> kNames{
      "upper left", "top", "upper right", "left", "middle", "right", "lower left", "bottom", "lower right"};
  return kNames[static_cast<std::size_t>(3 * row + column)];
}

BoardCoverage coverage_of(const CleanFit& clean, int width, int height) {
  constexpr int kCells = BoardCoverage::kCells;
  BoardCoverage coverage;
  coverage.farthest = clean.fit.lens.largest_angle;
  for (const auto& view : clean.views)
    for (const auto& pixel : view.pixels) {
      const int x = std::clamp(static_cast<int>((pixel.x + 0.5) / width * kCells), 0, kCells - 1);
      const int y = std::clamp(static_cast<int>((pixel.y + 0.5) / height * kCells), 0, kCells - 1);
      ++coverage.corners[static_cast<std::size_t>(y * kCells + x)];
    }
  // A fisheye's picture has black corners in which no board will ever be: only what lies within 90 deg counts.
  auto wide = clean.fit.lens;
  wide.largest_angle = from_degrees(90.0);
  const auto lens = make_lens(wide);
  int seeing = 0, covered = 0;
  std::array<int, 9> third_seeing{}, third_covered{};
  for (int y = 0; y < kCells; ++y)
    for (int x = 0; x < kCells; ++x) {
      if (!lens->unproject({(x + 0.5) * width / kCells - 0.5, (y + 0.5) * height / kCells - 0.5})) continue;
      const auto third = static_cast<std::size_t>(3 * (3 * y / kCells) + 3 * x / kCells);
      const bool hit = coverage.corners[static_cast<std::size_t>(y * kCells + x)] > 0;
      ++seeing;
      ++third_seeing[third];
      covered += hit ? 1 : 0;
      third_covered[third] += hit ? 1 : 0;
    }
  coverage.covered = seeing > 0 ? static_cast<double>(covered) / seeing : 0.0;
  std::vector<std::string_view> bare;
  for (int i = 0; i < 9; ++i)
    if (third_seeing[static_cast<std::size_t>(i)] > 0 && third_covered[static_cast<std::size_t>(i)] == 0)
      bare.push_back(place_name(i % 3, i / 3));
  for (const auto& a : clean.fit.views)
    for (const auto& b : clean.fit.views)
      coverage.largest_tilt = std::max(coverage.largest_tilt, angle_between(a.pose.rotation[2], b.pose.rotation[2]));

  if (!bare.empty())
    coverage.advice.push_back(
        fmt::format("no board was ever seen at: {}; take pictures with the board there", fmt::join(bare, ", ")));
  if (to_degrees(coverage.largest_tilt) < 20.0)
    coverage.advice.push_back(
        fmt::format("the boards are alike within {:.0f} deg, which leaves the focal length open; tilt the board by 30 "
                    "deg and more, both ways",
                    to_degrees(coverage.largest_tilt)));
  if (clean.views.size() < 10)
    coverage.advice.push_back(fmt::format("{} views are few; 15 to 20 are usual", clean.views.size()));
  return coverage;
}

}  // namespace

Result<LensCalibration> calibrate_lens(std::vector<BoardView> views, int width, int height,
                                       const LensCalibrationRequest& options) {
  if (views.size() < kFewestViews)
    return fail(FaultKind::bad_input, "the board was found in {} pictures: expected at least {}", views.size(),
                kFewestViews);
  LensCalibration result;
  std::vector<CleanFit> fits;
  for (const auto family : kLensFamilies) {
    if (options.family && *options.family != family) continue;
    if (auto clean = fit_without_outliers(family, views, width, height))
      fits.push_back(std::move(*clean));
    else
      result.candidates.push_back({family, std::nullopt});
  }
  if (fits.empty())
    return fail(FaultKind::bad_input,
                "no lens model fits the {} views: expected pictures of one flat board, all by the same camera at the "
                "same zoom and focus",
                views.size());
  // All models are compared on the same views: those kept by the model with the smallest residuals.
  const auto closest = std::min_element(
      fits.begin(), fits.end(), [](const CleanFit& a, const CleanFit& b) { return a.fit.rms_px < b.fit.rms_px; });
  const auto judged_by = closest->views;
  std::vector<std::optional<double>> errors;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& clean : fits) {
    errors.push_back(held_out_rms(clean.fit.family, judged_by, width, height, options.folds));
    result.candidates.push_back({clean.fit.family, errors.back()});
    least = std::min(least, errors.back().value_or(least));
  }
  auto chosen = static_cast<std::size_t>(closest - fits.begin());
  for (std::size_t i = 0; i < fits.size(); ++i)
    if (errors[i] && kWorthMore * *errors[i] <= least) {
      chosen = i;
      break;
    }
  CleanFit& clean = fits[chosen];
  result.coverage = coverage_of(clean, width, height);
  const Radians usual = clean.fit.lens.largest_angle + from_degrees(5.0);
  clean.fit.lens.largest_angle = std::min(options.largest_angle.value_or(usual), from_degrees(180.0));
  result.fit = std::move(clean.fit);
  result.views = std::move(clean.views);
  result.dropped = std::move(clean.dropped);
  return result;
}

}  // namespace kasumi
