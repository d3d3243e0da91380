#include "pipeline/install/calibrate/series_pictures.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "calib/mask/fixed_circle.hpp"
#include "calib/mask/square_pixels.hpp"
#include "pipeline/lab/photographs/estimate_inputs.hpp"
#include "pipeline/machine/progress.hpp"

namespace kasumi {
namespace {

constexpr std::size_t kMostForCircle = 60;

struct Size {
  int width = 0, height = 0;
  auto operator<=>(const Size&) const = default;
};

// The circle most pictures show, by all of them together.
std::optional<FoundCircle> common_circle(const std::vector<SizedCircle>& alone) {
  const auto circles = circles_of_fixed_cameras(alone);
  std::optional<FoundCircle> best;
  double most = 0.0;
  for (const auto& circle : circles) {
    if (!circle) continue;
    double votes = 0.0;
    for (const auto& other : circles)
      if (other && other->circle.centre == circle->circle.centre && other->circle.radius_px == circle->circle.radius_px)
        votes += other->confidence;
    if (votes > most || (votes == most && best && !best->horizon && circle->horizon)) {
      most = votes;
      best = circle;
    }
  }
  return best;
}

Result<> read_pictures(const std::vector<EstimateInput>& inputs, const PictureTimes& times, SeriesPictures& series) {
  std::map<Size, std::vector<SeriesFile>> by_size;
  Progress progress("reading", inputs.size());
  for (const EstimateInput& input : inputs) {
    progress.advance("");
    const auto utc = input.utc ? input.utc : picture_time(input.file, times);
    const auto photograph = read_photograph(input.file);
    if (!input.problem.empty() || !photograph) {
      ++series.unreadable;
      continue;
    }
    if (!utc) {
      ++series.without_time;
      continue;
    }
    by_size[{photograph->encoded.width(), photograph->encoded.height()}].push_back({input.file, *utc});
  }
  progress.clear();
  const auto usual = std::ranges::max_element(by_size, {}, [](const auto& one) { return one.second.size(); });
  if (usual == by_size.end())
    return fail(FaultKind::bad_input,
                "{} pictures, {} of them unreadable, {} without a time: expected times in their names (--time-format, "
                "like %Y%m%d_%H%M%S), by EXIF, or in a list: a path, a tab and a time like 2018-01-29T11:09:20Z",
                inputs.size(), series.unreadable, series.without_time);
  for (const auto& [size, pictures] : by_size)
    if (size != usual->first) series.of_other_size += static_cast<int>(pictures.size());
  std::tie(series.width, series.height) = std::pair(usual->first.width, usual->first.height);
  series.pictures = std::move(usual->second);
  std::ranges::sort(series.pictures, {}, &SeriesFile::utc);
  return {};
}

}  // namespace

void keep_brightest(Image<Rgb8>& brightest, const Image<Rgb8>& picture) {
  if (brightest.empty()) {
    brightest = picture;
    return;
  }
  for (std::size_t i = 0; i < picture.elements().size(); ++i)
    brightest.elements()[i] = glm::max(brightest.elements()[i], picture.elements()[i]);
}

Result<SeriesPictures> read_series(const std::vector<std::string>& what, const PictureTimes& times,
                                   const std::optional<ImageCircle>& circle) {
  EstimateRequest arguments;
  arguments.images = what;
  auto inputs = EstimateInputs::expand(arguments);
  if (!inputs) return fail(inputs.error());
  if (!inputs->problems().empty()) return fail(inputs->problems().fault());
  SeriesPictures series;
  if (auto read = read_pictures(inputs->all(), times, series); !read) return fail(read.error());

  std::vector<SizedCircle> circles;
  for_each_of(series, kMostForCircle, [&](const SeriesFile&, Photograph& photograph) {
    const auto picture = to_rgb8(photograph);
    keep_brightest(series.brightest, picture);
    if (!circle) circles.push_back({series.width, series.height, find_image_circle(picture)});
  });
  if (circle) {
    series.circle = FoundCircle{*circle, 1.0, {}, 1.0, {}};
    return series;
  }
  const auto found = common_circle(circles);
  if (!found || found->confidence < kLeastCircleConfidence)
    return fail(FaultKind::bad_input, "{}: no image circle is seen: expected a fisheye's pictures, or --circle CX,CY,R",
                what.front());
  series.circle = *found;
  series.brightest = with_square_pixels(std::move(series.brightest), found->pixel_aspect);
  return series;
}

void for_each_of(const SeriesPictures& series, std::size_t most,
                 const std::function<void(const SeriesFile&, Photograph&)>& use) {
  const std::size_t step = (series.pictures.size() + most - 1) / most;
  for (std::size_t i = 0; i < series.pictures.size(); i += step) {
    auto photograph = read_photograph(series.pictures[i].file);
    if (!photograph) continue;  // it was there a moment ago; the others are
    photograph->encoded = with_square_pixels(std::move(photograph->encoded), series.circle.pixel_aspect);
    use(series.pictures[i], *photograph);
  }
}

}  // namespace kasumi
