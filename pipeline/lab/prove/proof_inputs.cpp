#include "pipeline/lab/prove/proof_inputs.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "base/saturation.hpp"
#include "base/statistics.hpp"
#include "estimator/landmarks/daylight.hpp"
#include "estimator/photograph/lens_drops.hpp"
#include "estimator/photograph/other_air.hpp"
#include "estimator/photograph/same_view.hpp"
#include "pipeline/lab/photographs/estimate_inputs.hpp"
#include "pipeline/machine/progress.hpp"
#include "pipeline/site/config/descriptions.hpp"
#include "pipeline/site/files/photograph_file.hpp"

namespace kasumi {
namespace {

constexpr double kOrdinaryField_deg = 50.0;  // across, of a camera of which nothing is known: only for small turns
constexpr double kClippedShare = 0.05;       // of the sky beside: more is no light from infinity
constexpr double kIndependentPixels = 0.25;  // JPEG and demosaicing
constexpr double kPixelNoise = 2.0 / 255.0;

Image<Rgb8> cut(const Image<glm::vec3>& encoded, const LandmarkBox& box) {
  Image<Rgb8> part(box.width, box.height);
  for (int y = 0; y < box.height; ++y)
    for (int x = 0; x < box.width; ++x)
      for (int c = 0; c < 3; ++c)
        part.at(x, y)[c] = static_cast<std::uint8_t>(
            std::lround(255.0F * std::clamp(encoded.at(box.x + x, box.y + y)[c], 0.0F, 1.0F)));
  return part;
}

// A line through the rows' medians: birds, wires and cranes are few in a row.
FacadeBackdrop sky_in(const Camera& camera, const Image<glm::vec3>& encoded, const LandmarkBox& box, int top,
                      bool* clipped) {
  FacadeBackdrop sky;
  int full = 0;
  std::vector<glm::dvec3> rows;
  glm::dvec3 slope{0.0};
  for (int y = box.y; y < box.y + box.height; ++y) {
    std::array<std::vector<double>, 3> light;
    for (int x = box.x; x < box.x + box.width; ++x) {
      const glm::dvec3 value(encoded.at(x, y));
      full += std::max({value.r, value.g, value.b}) >= kSaturatedBox;
      const auto pixel = camera.light_at({x, y}, value);
      slope += camera.response.slope(value);
      for (std::size_t c = 0; c < 3; ++c) light[c].push_back(pixel[static_cast<int>(c)]);
    }
    rows.emplace_back(median(light[0]), median(light[1]), median(light[2]));
  }
  const double pixels = double(box.width) * box.height, middle = 0.5 * (box.height - 1);
  glm::dvec3 mean{0.0}, rising{0.0};
  double squares = 0.0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double row = static_cast<double>(i) - middle;
    mean += rows[i] / static_cast<double>(rows.size());
    rising += row * rows[i];
    squares += row * row;
  }
  sky.per_row = squares > 0.0 ? rising / squares : glm::dvec3{0.0};
  sky.light = mean + (top - box.y - middle) * sky.per_row;
  const auto noise = kPixelNoise * slope / pixels;
  sky.variance = noise * noise / std::max(1.0, kIndependentPixels * pixels);
  *clipped = full > kClippedShare * pixels;
  return sky;
}

LandmarkBox box_of(const std::vector<double>& numbers) {
  return {static_cast<int>(numbers[0]), static_cast<int>(numbers[1]), static_cast<int>(numbers[2]),
          static_cast<int>(numbers[3])};
}

bool within(const LandmarkBox& box, const Camera& camera) {
  return box.width > 0 && box.height > 0 && box.x >= 0 && box.y >= 0 && box.x + box.width <= camera.width &&
         box.y + box.height <= camera.height;
}

// As much around it as it is high, so that one sees what stands beside it.
LandmarkBox around(const LandmarkBox& part, const Camera& camera) {
  const int margin = std::max({20, part.height, part.width});
  const int left = std::max(0, part.x - margin), top = std::max(0, part.y - margin);
  const int right = std::min(camera.width, part.x + part.width + margin);
  const int bottom = std::min(camera.height, part.y + part.height + margin / 2);
  return {left, top, right - left, bottom - top};
}

Result<> find_part(const ProveRequest& request, std::vector<ContrastLandmark> landmarks, ProofInputs& scene) {
  Problems problems;
  const auto named = std::ranges::find(landmarks, request.part, &ContrastLandmark::name);
  if (named != landmarks.end()) scene.part = *named;
  scene.part.name = request.part;
  if (!request.region.empty()) scene.part.surface = box_of(request.region);
  if (!request.sky.empty()) scene.part.sky = box_of(request.sky);
  if (request.distance_m) scene.part.distance_m = *request.distance_m;
  if (named == landmarks.end() && request.region.empty()) {
    std::string names;
    for (const auto& landmark : landmarks) names += (names.empty() ? "" : ", ") + landmark.name;
    problems.add("--part {}: expected a landmark of --landmarks ({}), or --region-px X,Y,W,H", request.part,
                 names.empty() ? "none is given" : names);
  } else if (!within(scene.part.surface, scene.camera)) {
    problems.add("--region-px: expected X,Y,W,H within the pictures' {} x {} pixels", scene.camera.width,
                 scene.camera.height);
  }
  if (!scene.part.sky || !within(*scene.part.sky, scene.camera))
    problems.add("--part {}: expected the sky beside it: sky_px of the landmark, or --sky-px X,Y,W,H within {} x {}",
                 request.part, scene.camera.width, scene.camera.height);
  if (!(scene.part.distance_m > 0.0)) problems.add("--distance-m: expected how far away {} is", request.part);
  if (!problems.empty()) return fail(problems.fault());
  // Facades of one building are at one distance, and the part in question must not estimate its own air.
  for (auto& landmark : landmarks) {
    const bool own = landmark.name == request.part ||
                     (named != landmarks.end() && std::abs(landmark.distance_m - named->distance_m) < 0.5);
    if (own)
      scene.left_aside.push_back(landmark.name);
    else
      scene.others.push_back(std::move(landmark));
  }
  if (scene.others.empty() && request.air.empty())
    return fail(FaultKind::bad_input,
                "--landmarks: only {} itself would give the air: expected landmarks of other distances, or --air TABLE",
                request.part);
  scene.patch = around(scene.part.surface, scene.camera);
  return {};
}

Result<> know_camera(const ProveRequest& request, int width, int height, ProofInputs& scene) {
  scene.camera = plain_camera(width, height, from_degrees(kOrdinaryField_deg), Radians{0.0});
  std::vector<ContrastLandmark> landmarks;
  if (!request.landmarks.empty()) {
    auto file = read_landmark_file(request.landmarks, width, height);
    if (!file) return fail(file.error());
    if (file->scene) scene.camera = *file->scene;
    scene.altitude_m = file->altitude_m;
    scene.site = file->site;
    landmarks = std::move(file->landmarks);
  }
  if (request.lat && request.lon) scene.site = Site{"", *request.lat, *request.lon, scene.altitude_m};
  return find_part(request, std::move(landmarks), scene);
}

Result<std::vector<ProofView>> listed(const ProveRequest& request) {
  EstimateRequest arguments;
  arguments.images = request.scenes;
  auto inputs = EstimateInputs::expand(arguments);
  if (!inputs) return fail(inputs.error());
  Problems problems = inputs->problems();
  std::vector<ProofView> views;
  for (const auto& input : inputs->all()) {
    if (!input.problem.empty()) problems.add("{}", input.problem);
    ProofView view;
    view.file = input.file;
    view.utc = input.utc ? input.utc : picture_time(input.file, request.times);
    view.label = input.label;
    views.push_back(std::move(view));
  }
  if (!problems.empty()) return fail(problems.fault());
  std::ranges::stable_sort(views, {}, [](const ProofView& view) { return view.utc.value_or(Utc{}); });
  return views;
}

// First pass: where each picture looked.
Result<SameViews> place(const ProveRequest& request, ProofInputs& scene) {
  std::vector<ViewLines> lines;
  std::vector<DetailFineness> fineness;
  std::vector<ProofView> good;
  std::optional<std::size_t> reference;
  Progress progress("placing", scene.views.size());
  for (auto& view : scene.views) {
    progress.advance(view.file.filename().string());
    const auto photograph = read_photograph(view.file);
    if (!photograph) {
      ++scene.unreadable;
      continue;
    }
    const auto& encoded = photograph->encoded;
    if (good.empty())
      if (auto known = know_camera(request, encoded.width(), encoded.height(), scene); !known)
        return fail(known.error());
    if (encoded.width() != scene.camera.width || encoded.height() != scene.camera.height) {
      ++scene.unreadable;
      continue;
    }
    std::error_code error;
    if (!request.reference.empty() && std::filesystem::equivalent(view.file, request.reference, error))
      reference = good.size();
    lines.push_back(lines_of_picture(*scene.camera.lens, encoded));
    fineness.push_back(fineness_of(encoded));
    good.push_back(std::move(view));
  }
  progress.clear();
  scene.views = std::move(good);
  if (scene.views.empty()) return fail(FaultKind::bad_input, "{}: no picture that can be read", request.scenes.front());
  if (!request.reference.empty() && !reference)
    return fail(FaultKind::bad_input, "--reference {}: expected one of the pictures", request.reference);
  auto same = place_views(lines, reference);
  if (!same) return fail(FaultKind::bad_input, "{}: no two pictures show the same view", request.scenes.front());
  const auto blurred = blurred_shares(fineness);
  for (std::size_t i = 0; i < blurred.size(); ++i) scene.views[i].blurred_share = blurred[i];
  scene.reference = scene.views[same->reference].file;
  return *same;
}

double moved_px(const LandmarkBox& part, const ViewMove& move) {
  const glm::dvec2 middle{part.x + 0.5 * part.width, part.y + 0.5 * part.height};
  return glm::distance(move.at(middle), middle);
}

}  // namespace

Image<glm::vec3> ProofInputs::part_of(const ProofView& view) const {
  Image<glm::vec3> encoded(part.surface.width, part.surface.height);
  for (int y = 0; y < encoded.height(); ++y)
    for (int x = 0; x < encoded.width(); ++x)
      encoded.at(x, y) = glm::vec3(view.patch.at(x + part.surface.x - patch.x, y + part.surface.y - patch.y)) / 255.0F;
  return encoded;
}

Image<glm::vec3> ProofInputs::light_of_part(const Image<glm::vec3>& encoded) const {
  Image<glm::vec3> light(encoded.width(), encoded.height());
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x)
      light.at(x, y) = camera.light_at({part.surface.x + x, part.surface.y + y}, glm::dvec3(encoded.at(x, y)));
  return light;
}

Result<ProofInputs> read_proof_inputs(const ProveRequest& request) {
  ProofInputs scene;
  auto views = listed(request);
  if (!views) return fail(views.error());
  scene.views = std::move(*views);
  auto same = place(request, scene);
  if (!same) return fail(same.error());
  const LandmarkWatch watch(scene.camera, scene.altitude_m, scene.others);
  Progress progress("reading", scene.views.size());
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    auto& view = scene.views[i];
    progress.advance(view.file.filename().string());
    const auto photograph = read_photograph(view.file);
    if (!photograph) return fail(photograph.error());
    const auto& placed = same->views[i];
    view.placed = placed.seen;
    view.moved_px = moved_px(scene.part.surface, placed.move);
    const auto encoded = moved_back(photograph->encoded, placed.move);
    view.unusable = why_not_daylight(look_for_daylight(encoded));
    view.readings = watch.read(scene.camera, encoded);
    view.sky = sky_in(scene.camera, encoded, *scene.part.sky, scene.part.surface.y, &view.sky_clipped);
    view.patch = cut(encoded, scene.patch);
  }
  return scene;
}

}  // namespace kasumi
