#include "calib/distances/distance_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "calib/distances/distance_numbers.hpp"
#include "calib/distances/sparse_distances.hpp"

namespace kasumi {
namespace {

constexpr double kSameShape = 0.02;   // of the sides' ratio: networks take sides that are multiples of 14 or 32
constexpr float kOneSurface = 0.05F;  // neighbours that differ by less are of one surface
constexpr double kSuspiciouslyNear_m = 1.0;
constexpr double kLargestDisparity_px = 32768.0;  // among floats; Middlebury has inf
constexpr float kSkyMetres = std::numeric_limits<float>::infinity();
constexpr float kZeroInFile = -1.0F;  // until it is known whether the map is sparse
constexpr const char* kStepMissing =
    "expected the metres that a step of this file is, too (--depth-step-m, depth_step_m; .001: millimetres)";

bool is_known(float metres) {
  return metres > 0.0F && metres < kSkyMetres;
}

// One value in metres; 0: not known, infinity: sky, kZeroInFile. Empty: an error.
std::optional<float> metres_of(double value, const DistanceFile& file, const DistanceNumbers& numbers) {
  using Holds = DistanceFile::Holds;
  const bool of_distance = file.holds == Holds::metres;
  if (std::isnan(value) || value == file.no_data || (of_distance && value == numbers.saturated)) return 0.0F;
  if (of_distance && value == numbers.background) return kSkyMetres;
  if (value < 0.0 && file.holds != Holds::inverse) return std::nullopt;
  if (value == 0.0 && file.holds != Holds::inverse) return of_distance ? kZeroInFile : 0.0F;
  const double scale = file.scale.value_or(1.0);
  double metres = scale * value;
  if (file.holds == Holds::disparity) {
    if ((!numbers.are_whole && value > kLargestDisparity_px) || value + file.offset <= 0.0) return 0.0F;
    metres = scale / (value + file.offset);
  } else if (file.holds == Holds::inverse) {
    const double inverse = scale * value + file.offset;
    metres = inverse > 0.0 ? 1.0 / inverse : double{kSkyMetres};
  }
  return metres > file.sky_beyond_m ? kSkyMetres : static_cast<float>(metres);
}

Result<Image<float>> all_metres(const DistanceNumbers& numbers, const DistanceFile& file, const std::string& name) {
  const auto& values = numbers.values;
  Image<float> metres(values.cols, values.rows);
  for (int y = 0; y < values.rows; ++y)
    for (int x = 0; x < values.cols; ++x) {
      const double value = numbers.are_whole ? values.at<std::uint16_t>(y, x) : values.at<float>(y, x);
      const auto here = metres_of(value, file, numbers);
      if (!here)
        return fail(FaultKind::bad_input,
                    "{}: expected metres >= 0 (pixel {}, {} is {}); or the number that stands for no "
                    "distance (--no-data, depth_no_data)",
                    name, x, y, value);
      metres.at(x, y) = *here;
    }
  return metres;
}

// Between pixels of one surface linear in 1 / distance, as planes are; else the nearest.
float sampled(const Image<float>& map, double x, double y) {
  const auto at = [&](int column, int row) {
    return map.at(std::clamp(column, 0, map.width() - 1), std::clamp(row, 0, map.height() - 1));
  };
  const float nearest = at(static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y)));
  const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
  double inverse = 0.0;
  for (const int i : {0, 1})
    for (const int j : {0, 1}) {
      const float metres = at(left + i, top + j);
      if (!is_known(metres) || !is_known(nearest) || std::abs(metres - nearest) > kOneSurface * nearest) return nearest;
      const double fx = x - left, fy = y - top;
      inverse += (i ? fx : 1.0 - fx) * (j ? fy : 1.0 - fy) / static_cast<double>(metres);
    }
  return static_cast<float>(1.0 / inverse);
}

Image<float> resampled(const Image<float>& map, int width, int height) {
  Image<float> made(width, height);
  const double across = static_cast<double>(map.width()) / width, down = static_cast<double>(map.height()) / height;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) made.at(x, y) = sampled(map, (x + 0.5) * across - 0.5, (y + 0.5) * down - 0.5);
  return made;
}

bool same_shape(int width, int height, int other_width, int other_height) {
  const double ratio = static_cast<double>(width) / height * other_height / other_width;
  return std::abs(ratio - 1.0) <= kSameShape;
}

// Land goes away upwards: what is nearer in the upper third of what is known than in the lower is upside down, or
// nearness.
bool is_nearer_above(const Image<float>& metres) {
  int first = metres.height(), last = -1;
  for (int y = 0; y < metres.height(); ++y)
    for (int x = 0; x < metres.width(); ++x)
      if (is_known(metres.at(x, y))) {
        first = std::min(first, y);
        last = y;
      }
  std::vector<float> above, below;
  const int height = last - first + 1;
  for (int y = first; y <= last; ++y)
    for (int x = 0; x < metres.width(); ++x)
      if (is_known(metres.at(x, y))) {
        if (3 * (y - first) < height) above.push_back(metres.at(x, y));
        if (3 * (y - first) >= 2 * height) below.push_back(metres.at(x, y));
      }
  if (above.size() < 16 || below.size() < 16) return false;
  const auto median = [](std::vector<float>& of) {
    const auto middle = of.begin() + static_cast<std::ptrdiff_t>(of.size() / 2);
    std::nth_element(of.begin(), middle, of.end());
    return *middle;
  };
  return median(above) < 0.5F * median(below);
}

void measure(DistanceMap& map) {
  double known = 0.0, sky = 0.0;
  float nearest = kSkyMetres, farthest = 0.0F;
  for (const float metres : map.metres.elements()) {
    if (metres == kSkyMetres) ++sky;
    if (!is_known(metres)) continue;
    ++known;
    nearest = std::min(nearest, metres);
    farthest = std::max(farthest, metres);
  }
  const auto count = static_cast<double>(map.metres.elements().size());
  map.known = known / count;
  map.sky = sky / count;
  map.near_m = known > 0.0 ? static_cast<double>(nearest) : 0.0;
  map.far_m = farthest;
}

std::string metres_text(double metres) {
  return metres < 1000.0 ? fmt::format("{:.4g}", metres) : fmt::format("{:.0f}", metres);
}

}  // namespace

std::string DistanceMap::summary() const {
  auto text = fmt::format("{} to {} m in {:.1f} % of the picture, sky in {:.1f} %, nothing known in {:.1f} %",
                          metres_text(near_m), metres_text(far_m), 100.0 * known, 100.0 * sky,
                          100.0 * std::max(0.0, 1.0 - known - sky));
  for (const auto& remark : remarks) text += "; " + remark;
  return text;
}

Result<DistanceMap> read_distances(const std::filesystem::path& path, const DistanceFile& file, int width, int height) {
  const auto name = path.string();
  const auto numbers = read_distance_numbers(path, file.channel);
  if (!numbers) return fail(numbers.error());
  const auto& values = numbers->values;
  if (!same_shape(values.cols, values.rows, width, height))
    return fail(FaultKind::bad_input,
                "{}: expected a map as large as the camera's pictures, {} x {} (it is {} x {}), or of their shape",
                name, width, height, values.cols, values.rows);
  if (numbers->are_whole && !file.scale) return fail(FaultKind::bad_input, "{}: {}", name, kStepMissing);
  auto metres = all_metres(*numbers, file, name);
  if (!metres) return fail(metres.error());
  DistanceMap map;
  map.metres = std::move(*metres);
  map.remarks = numbers->remarks;
  const auto filled = fill_sparse(map.metres);
  if (!filled.empty()) map.remarks.push_back(filled);
  for (float& value : map.metres.elements())
    if (value == kZeroInFile) value = file.zero_is_sky && filled.empty() ? kSkyMetres : 0.0F;
  if (map.metres.width() != width || map.metres.height() != height) {
    map.remarks.push_back(fmt::format("resampled from {} x {}", map.metres.width(), map.metres.height()));
    map.metres = resampled(map.metres, width, height);
  }
  measure(map);
  if (!(map.known > 0.0))
    return fail(FaultKind::bad_input, "{}: nothing is known in any pixel ({:.1f} % sky): expected distances{}", name,
                100.0 * map.sky, numbers->other_channels.empty() ? "" : "; other channels: " + numbers->other_channels);
  if (!numbers->are_whole && !file.scale && map.far_m <= kSuspiciouslyNear_m)
    return fail(
        FaultKind::bad_input,
        "{}: all within {:.3g} to {:.3g} m: expected metres; of relative distances say what 1 is (--depth-step-m, "
        "depth_step_m), of a network's nearness --inverse-depth, --inverse-scale",
        name, map.near_m, map.far_m);
  if (is_nearer_above(map.metres)) {
    if (!numbers->are_whole && !file.scale)
      return fail(
          FaultKind::bad_input,
          "{}: nearer above than below, as a network's nearness or disparities are: expected --inverse-depth "
          "with --inverse-scale, or --disparity; if these are metres, say so by --depth-step-m 1 (depth_step_m)",
          name);
    map.remarks.push_back("nearer above than below: upside down, or inverse depth?");
  }
  return map;
}

Image<float> sky_as_zero(const DistanceMap& map, double smallest_sky_share) {
  auto metres = map.metres;
  fill_small_holes(metres, smallest_sky_share);
  for (float& value : metres.elements())
    if (!is_known(value)) value = 0.0F;
  return metres;
}

Image<float> read_distance_map(const ConfigTable& scene, int width, int height, std::string* summary) {
  const auto path = scene.optional_file("depth_map");
  const auto number = [&](const char* key, Range range) {
    const double value = scene.number(key, range, 0.0);
    return scene.has(key) ? std::optional(value) : std::nullopt;
  };
  DistanceFile file;
  file.scale = number("depth_step_m", {1e-5, 1e3});
  file.no_data = number("depth_no_data", {-1e38, 1e38});
  file.sky_beyond_m = scene.number("depth_sky_beyond_m", {1.0, 400e3}, kSkyBeyond_m);
  file.channel = scene.text("depth_channel", "");
  file.zero_is_sky = true;
  const auto inverse_scale = number("depth_inverse_scale", {1e-12, 1e12});
  const auto inverse_offset = number("depth_inverse_offset", {-1e6, 1e6});
  if (inverse_scale && file.scale) scene.problem("depth_step_m", "either this or depth_inverse_scale, not both");
  if (inverse_offset && !inverse_scale) scene.problem("depth_inverse_offset", "it together with depth_inverse_scale");
  if (inverse_scale) {
    file.holds = DistanceFile::Holds::inverse;
    file.scale = inverse_scale;
    file.offset = inverse_offset.value_or(0.0);
  }
  for (const char* key :
       {"depth_step_m", "depth_no_data", "depth_sky_beyond_m", "depth_channel", "depth_inverse_scale"})
    if (!path && scene.has(key)) scene.problem(key, "it together with depth_map, whose numbers it explains");
  std::error_code error;
  if (!path || !std::filesystem::is_regular_file(*path, error)) return {};
  const auto map = read_distances(*path, file, width, height);
  if (map) {
    if (summary) *summary = fmt::format("depth_map {}: {}", path->filename().string(), map->summary());
    return sky_as_zero(*map);
  }
  if (map.error().message.ends_with(kStepMissing))
    scene.problem("depth_step_m", "the metres that a step of depth_map is");
  else
    scene.problem("depth_map", fmt::format("a map of distances ({})", map.error().message));
  return {};
}

}  // namespace kasumi
