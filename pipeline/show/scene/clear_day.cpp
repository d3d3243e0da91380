#include "pipeline/show/scene/clear_day.hpp"

#include <algorithm>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "gles/gl/offscreen.hpp"

namespace kasumi {

Frame rgb_frame(const Image<Rgb8>& picture) {
  Frame frame;
  frame.metadata.format = four_cc("RGB3");
  frame.metadata.width = picture.width();
  frame.metadata.height = picture.height();
  frame.metadata.stride = static_cast<std::uint32_t>(3 * picture.width());
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(picture.elements().data());
  std::vector<std::uint8_t> copy(bytes, bytes + 3 * picture.elements().size());
  frame.metadata.bytes_used = static_cast<std::uint32_t>(copy.size());
  frame.payload = payload_of(std::move(copy));
  return frame;
}

SkyReport clear_day(const Direction& sun) {
  SkyReport report;
  report.sun.source = SunSource::ephemeris;
  report.sun.direction = glm::normalize(sun);
  report.estimate.sky = SkyCondition::clear;
  return report;
}

Image<Rgb8> backdrop(const Installation& installation, const SkyReport& sky, const std::optional<Turbidity>& air,
                     double exposure) {
  constexpr double kHorizon = 0.34, kLand = 0.3;  // green, linear; of the horizon's light
  const glm::dvec3 grass{0.8, 1.0, 0.5};
  const Camera& camera = installation.scene;
  const auto conditions = SceneAir(installation, {.turbidity = air}).conditions(sky);
  const auto& around = installation.surroundings;
  const Daylight daylight(
      camera, conditions.air, conditions.sun,
      {conditions.sky, around.ground_albedo, installation.site.altitude_m, around.sky_model, nullptr, 1.0});
  const auto light_from = [&](const Direction& direction) {
    return daylight.airlight(direction) * camera.white_balance;
  };
  const glm::dvec3 ahead = camera.to_world * glm::dvec3{0.0, 0.0, 1.0};
  const double unit = exposure * kHorizon / light_from(glm::normalize(glm::dvec3{ahead.x, ahead.y, 0.0})).g;
  Image<Rgb8> picture(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Direction direction = camera.direction_at({x, y}).value_or(Direction{0.0, 0.0, 1.0});
      const glm::dvec3 above = unit * light_from(direction);
      const glm::dvec3 light = glm::mix(above, kLand * grass * above.g, std::clamp(-60.0 * direction.z, 0.0, 1.0));
      picture.at(x, y) = Rgb8(glm::round(255.0 * glm::clamp(camera.response.to_encoded(light), 0.0, 1.0)));
    }
  }
  return picture;
}

// A compositor for each: it would carry the light of one day into the next.
Result<std::vector<Image<Rgb8>>> drawn_over(GlContext& context, const Installation& installation, const Model& model,
                                            const std::vector<ClearDay>& days,
                                            std::shared_ptr<const CompositorInputs> prepared) {
  if (!prepared) prepared = std::make_shared<const CompositorInputs>(prepare_scene(installation, model));
  std::vector<Image<Rgb8>> pictures;
  for (const auto& [sky, behind] : days) {
    auto compositor =
        Compositor::create(context, installation, model, SceneAir(installation, AirRendering{}), {}, prepared);
    if (!compositor) return fail(compositor.error());
    auto target = Offscreen::create(context.info(), installation.scene.width, installation.scene.height);
    if (!target) return fail(target.error());
    if (auto drawn = compositor->draw(rgb_frame(behind), sky, target->target()); !drawn) return fail(drawn.error());
    auto picture = target->read();
    if (!picture) return fail(picture.error());
    pictures.push_back(std::move(*picture));
  }
  return pictures;
}

}  // namespace kasumi
