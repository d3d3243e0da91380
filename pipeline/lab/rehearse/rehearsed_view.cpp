#include "pipeline/lab/rehearse/rehearsed_view.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

#include "estimator/sky/sun.hpp"
#include "gles/gl/offscreen.hpp"
#include "pipeline/show/scene/clear_day.hpp"
#include "pipeline/show/scene/compositor.hpp"
#include "pipeline/site/config/opening_hours.hpp"

namespace kasumi {

Utc utc_of(std::chrono::local_time<Duration> wall, const std::string& time_zone, double longitude_deg) {
  const Utc solar = Utc(wall.time_since_epoch()) - from_seconds(240.0 * longitude_deg);
  if (time_zone.empty()) return solar;
  Utc utc = solar;
  for (int i = 0; i < 2; ++i) utc += wall - local_time(time_zone, utc);  // again, where the clock is set in between
  return utc;
}

double brightness_under(const Direction& sun) {
  constexpr double kWhole_deg = 6.0, kFollowed_deg = -3.0, kTenth_deg = 2.7, kDusk = 0.7;
  const double up_deg = to_degrees({std::atan2(sun.z, std::hypot(sun.x, sun.y))});
  const double dusk = kDusk * std::clamp((kWhole_deg - up_deg) / (kWhole_deg - kFollowed_deg), 0.0, 1.0);
  return std::pow(10.0, -dusk - std::max(0.0, kFollowed_deg - up_deg) / kTenth_deg);
}

namespace {

template <class Pixel>
Image<Pixel> every_nth(const Image<Pixel>& from, int width, int height) {
  if (from.empty()) return {};
  Image<Pixel> made(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      made.at(x, y) = from.at((2 * x + 1) * from.width() / (2 * width), (2 * y + 1) * from.height() / (2 * height));
  return made;
}

Rgb8 darkened(Rgb8 pixel, double brightness, const Response& response) {
  const glm::dvec3 light = brightness * response.to_light(glm::dvec3(pixel) / 255.0);
  return Rgb8(glm::round(255.0 * glm::clamp(response.to_encoded(light), 0.0, 1.0)));
}

}  // namespace

Installation with_small_scene(Installation kiosk, int most_width) {
  Camera& scene = kiosk.scene;
  auto model = scene.lens ? pinhole_model(*scene.lens) : std::nullopt;
  if (!model || scene.width <= most_width) return kiosk;
  const int width = most_width, height = std::max(2, scene.height * most_width / scene.width / 2 * 2);
  const glm::dvec2 scale(1.0 * width / scene.width, 1.0 * height / scene.height);
  const auto moved = [&](const glm::dvec2& pixel) { return (pixel + 0.5) * scale - 0.5; };
  model->focal_px *= scale;
  model->centre = moved(model->centre);
  scene.lens = pinhole_lens(*model);
  scene.vignetting.centre = moved(scene.vignetting.centre);
  scene.vignetting.radius_px *= scale.x;
  scene.mask = every_nth(scene.mask, width, height);
  kiosk.scene_distances_m = every_nth(kiosk.scene_distances_m, width, height);
  kiosk.scene_quality.point_spread_px *= scale.x;
  kiosk.surroundings.haze_blur_px *= scale.x;
  kiosk.cards.clear();  // they lie elsewhere in the picture now, and there is none to read
  scene.width = width;
  scene.height = height;
  return kiosk;
}

struct RehearsedView::Parts {
  const Installation& installation;
  Turbidity air;
  Compositor compositor;
  Offscreen target;
  Instant now{};
};

RehearsedView::RehearsedView(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
RehearsedView::RehearsedView(RehearsedView&&) noexcept = default;
RehearsedView& RehearsedView::operator=(RehearsedView&&) noexcept = default;
RehearsedView::~RehearsedView() = default;

Result<RehearsedView> RehearsedView::create(GlContext& context, const Installation& installation, const Model& model,
                                            Turbidity air) {
  AirRendering options;
  options.turbidity = air;
  auto compositor = Compositor::create(context, installation, model, options);
  if (!compositor) return fail(compositor.error());
  auto target = Offscreen::create(context.info(), installation.scene.width, installation.scene.height);
  if (!target) return fail(target.error());
  return RehearsedView(
      std::unique_ptr<Parts>(new Parts{installation, air, std::move(*compositor), std::move(*target)}));
}

Result<Image<Rgb8>> RehearsedView::draw(Utc utc) {
  auto& at = *parts_;
  const SkyReport sky = clear_day(sun_position(utc, at.installation.site).direction);
  const Camera& scene = at.installation.scene;
  const double brightness = brightness_under(sky.sun.direction);
  // By night there is nothing to draw.
  if (constexpr Rgb8 kBlack{0}; darkened(Rgb8{255}, brightness, scene.response) == kBlack)
    return Image<Rgb8>(scene.width, scene.height, kBlack);
  Frame frame = rgb_frame(backdrop(at.installation, sky, at.air));
  // So long after the one before that nothing of its light is left.
  frame.metadata.captured_at = at.now += std::chrono::hours(24);
  if (auto drawn = at.compositor.draw(frame, sky, at.target.target()); !drawn) return fail(drawn.error());
  auto picture = at.target.read();
  // Only then: in a black picture no horizon is found, by which the building is lit.
  if (picture && brightness < 1.0)
    for (Rgb8& pixel : picture->elements()) pixel = darkened(pixel, brightness, scene.response);
  return picture;
}

}  // namespace kasumi
