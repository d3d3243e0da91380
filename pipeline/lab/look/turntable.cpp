#include "pipeline/lab/look/turntable.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "pipeline/show/scene/clear_day.hpp"

namespace kasumi {

namespace {

constexpr int kViewWidth = 480, kViewHeight = 360;
constexpr double kViewFocal_px = 660.0;
constexpr double kLookDown_deg = 8.0;
constexpr double kRadius_m = 30.0;  // every model is drawn as large as a temple, so that no air is in between

ClearDay afternoon(const Installation& installation, double exposure = 1.0) {
  const SkyReport sky = clear_day(kAfternoon);
  return {sky, backdrop(installation, sky, std::nullopt, exposure)};
}

bool differs(const Rgb8& a, const Rgb8& b) {
  const glm::ivec3 by = glm::abs(glm::ivec3(a) - glm::ivec3(b));
  return std::max({by.x, by.y, by.z}) > 2;
}

// What differs from the backdrop, with some of its surroundings.
Image<Rgb8> changed_part(const Image<Rgb8>& picture, const Image<Rgb8>& before) {
  int left = picture.width(), right = -1, top = picture.height(), bottom = -1;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      if (!differs(picture.at(x, y), before.at(x, y))) continue;
      left = std::min(left, x), right = std::max(right, x), top = std::min(top, y), bottom = std::max(bottom, y);
    }
  if (right < 0) return {};
  const int margin = std::max(8, (right - left) / 4);
  left = std::max(0, left - margin), right = std::min(picture.width() - 1, right + margin);
  top = std::max(0, top - margin), bottom = std::min(picture.height() - 1, bottom + margin);
  const int times = std::max(1, kViewWidth / (right - left + 1));
  Image<Rgb8> part((right - left + 1) * times, (bottom - top + 1) * times);
  for (int y = 0; y < part.height(); ++y)
    for (int x = 0; x < part.width(); ++x) part.at(x, y) = picture.at(left + x / times, top + y / times);
  return part;
}

Installation table_for(const Model& model, UpAxis up, int side) {
  Installation table;
  table.site = {"", 34.0, 135.0, 100.0};
  table.surroundings.sky_model = DaylightModel::dome;
  Camera& camera = table.scene;
  camera.name = "scene";
  camera.width = kViewWidth;
  camera.height = kViewHeight;
  camera.lens = pinhole_lens({{kViewFocal_px, kViewFocal_px}, {0.5 * kViewWidth - 0.5, 0.5 * kViewHeight - 0.5}, {}});
  camera.to_world = camera_to_world(Radians{0.0}, from_degrees(-kLookDown_deg), Radians{0.0});
  const auto box = model.bounds();
  const glm::dvec3 lowest(box.lowest), highest(box.highest);
  Placement& placement = table.object.placement;
  placement.up_axis = up;
  placement.heading = from_degrees(45.0 * side);
  placement.scale = kRadius_m / std::max(0.5 * glm::length(highest - lowest), 1e-6);
  const glm::dvec3 centre(model_to_world(placement) * glm::dvec4(0.5 * (lowest + highest), 1.0));
  // The nearest distance at which all of it is in the picture from each side.
  const glm::dvec3 size =
      glm::abs(glm::dmat3(model_to_world({.scale = placement.scale, .up_axis = up})) * (highest - lowest));
  const double wide = 0.5 * std::hypot(size.x, size.y), high = 0.5 * size.z;
  const double away = wide + 1.1 * kViewFocal_px * std::max(wide / (0.5 * kViewWidth), high / (0.5 * kViewHeight));
  const Radians down = from_degrees(kLookDown_deg);
  placement.east_m = -centre.x;
  placement.north_m = away * std::cos(down.value) - centre.y;
  placement.up_m = -away * std::sin(down.value) - centre.z;
  return table;
}

// One model on the table, cut into pieces once.
class TurnedModel {
 public:
  TurnedModel(GlContext& context, const Model& model, UpAxis up)
      : context_(context),
        model_(model),
        up_(up),
        prepared_(std::make_shared<const CompositorInputs>(prepare_scene(table_for(model, up, 0), model))) {}

  Installation table(int side) const { return table_for(model_, up_, side); }

  Result<Image<Rgb8>> view(int side, double exposure) const {
    const Installation from = table(side);
    auto view = drawn_over(context_, from, model_, {afternoon(from, exposure)}, prepared_);
    if (!view) return fail(view.error());
    return std::move(view->front());
  }

 private:
  GlContext& context_;
  const Model& model_;
  UpAxis up_;
  std::shared_ptr<const CompositorInputs> prepared_;
};

// In eighths of a stop, so that all but equal models are exposed alike.
Result<double> exposure_for(const TurnedModel& model) {
  constexpr double kTrial = 0.2;                // at which no model's brightest fiftieth is white
  constexpr double kBright = 0.95;              // linear: 249 of 255
  constexpr double kLeast = 0.1, kMost = 1.25;  // the sky stays below white
  std::vector<double> light;                    // of the model's pixels, of the brightest channel
  const Response response = Response::srgb();
  for (int side = 0; side < 8; side += 2) {
    const auto picture = model.view(side, kTrial);
    if (!picture) return fail(picture.error());
    const Image<Rgb8> before = afternoon(model.table(side), kTrial).backdrop;
    for (std::size_t i = 0; i < before.elements().size(); ++i)
      if (const Rgb8& texel = picture->elements()[i]; differs(texel, before.elements()[i]))
        light.push_back(response.to_light(glm::dvec3(std::max({texel.r, texel.g, texel.b})) / 255.0).g);
  }
  if (light.empty()) return 1.0;
  const auto brightest = light.begin() + static_cast<std::ptrdiff_t>(light.size() - 1 - light.size() / 50);
  std::ranges::nth_element(light, brightest);
  const double wanted = std::clamp(kTrial * kBright / std::max(*brightest, 1e-3), kLeast, kMost);
  return std::exp2(std::floor(8.0 * std::log2(wanted)) / 8.0);
}

}  // namespace

Result<Turntable> turntable(GlContext& context, const Model& model, UpAxis up) {
  const TurnedModel on_table(context, model, up);
  const auto exposure = exposure_for(on_table);
  if (!exposure) return fail(exposure.error());
  Turntable turned{{}, *exposure};
  for (int side = 0; side < 8; ++side) {
    auto view = on_table.view(side, *exposure);
    if (!view) return fail(view.error());
    turned.views.push_back(std::move(*view));
  }
  return turned;
}

Result<KioskView> seen_from_kiosk(GlContext& context, const Installation& installation, const Model& model) {
  const ClearDay day = afternoon(installation);
  auto drawn = drawn_over(context, installation, model, {day});
  if (!drawn) return fail(drawn.error());
  auto enlarged = changed_part(drawn->front(), day.backdrop);
  return KioskView{std::move(drawn->front()), std::move(enlarged)};
}

}  // namespace kasumi
