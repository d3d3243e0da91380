#include "pipeline/site/config/installation.hpp"

#include <fmt/ranges.h>

#include "base/utc_text.hpp"
#include "calib/distances/distance_map.hpp"
#include "estimator/sky_fit/tone_curve.hpp"
#include "gles/scene.hpp"
#include "pipeline/site/config/cards.hpp"
#include "pipeline/site/config/given_air_keys.hpp"

namespace kasumi {

namespace {

FogLayer read_fog(const ConfigTable& table) {
  return {table.number("extinction_per_m", {0.0, 1.0}), table.number("base_altitude_m", {-500.0, 9000.0}),
          table.number("scale_height_m", {1.0, 5000.0}, FogLayer{}.scale_height_m)};
}

Surroundings read_surroundings(const ConfigTable& table) {
  const Surroundings usual;
  Surroundings found{table.number("ground_albedo", {0.0, 1.0}, usual.ground_albedo),
                     table.number("cloud_base_m", {50.0, 15e3}, usual.cloud_base_m),
                     usual.fog,
                     usual.sky_model,
                     read_given_air(table),
                     usual.haze_blur_px};
  if (const auto fog = table.optional_table("fog")) found.fog = read_fog(*fog);
  const auto model =
      table.choice("sky_model", {"automatic", "preetham", "dome"}, std::string(name_of(usual.sky_model)));
  found.sky_model = daylight_model_named(model).value_or(usual.sky_model);
  found.haze_blur_px = table.number("haze_blur_px", {0.0, kWidestPointSpread_px}, usual.haze_blur_px);
  return found;
}

}  // namespace

ModelToFit Installation::model_to_fit() const {
  const auto model = resolved(surroundings.sky_model, site.altitude_m, surroundings.air.any());
  ModelToFit fit{model, site.altitude_m, model == DaylightModel::dome ? surroundings.air.to_be_found() : std::nullopt};
  fit.every_model = surroundings.sky_model == DaylightModel::automatic;
  fit.known = surroundings.air;
  return fit;
}

std::optional<double> Installation::given_saturation() const {
  if (scene_quality.saturation) return scene_quality.saturation;
  const bool curve_measured = scene.response.kind() != Response::Kind::srgb && !scene_tone_exponent;
  const bool measured = scene.colour_space != Camera::ColourSpace::srgb || curve_measured;
  return measured ? std::optional(1.0) : std::nullopt;
}

namespace {

std::optional<double> correct_tone(const ConfigTable& scene, Response& response) {
  if (!scene.has("tone_exponent")) return std::nullopt;
  const double exponent = scene.number("tone_exponent", {0.3, 3.0});
  if (response.kind() != Response::Kind::srgb) {
    scene.problem("tone_exponent", "none unless response is \"srgb\": it corrects a curve that is only supposed");
    return std::nullopt;
  }
  response = corrected(response, exponent);
  return exponent;
}

}  // namespace

Installation read_installation(const ConfigTable& root) {
  Installation installation;
  installation.calibration = adopt_calibration(root);
  installation.site = read_site(root.table("site"));
  installation.surroundings = read_surroundings(root.table("site"));
  installation.sky = read_camera(root.table("sky"), "sky");
  const auto scene = root.table("scene");
  installation.scene = read_camera(scene, "scene");
  installation.scene_tone_exponent = correct_tone(scene, installation.scene.response);
  installation.scene_quality = read_image_quality(scene);
  installation.scene_distances_m =
      read_distance_map(scene, installation.scene.width, installation.scene.height, &installation.depth_map);
  installation.people_in_front = scene.flag("people_in_front", false);
  if (installation.scene.lens && !pinhole_model(*installation.scene.lens))
    scene.table("lens").problem("model",
                                "\"pinhole\": the picture is drawn through a pinhole (with Brown's distortion)");
  installation.object = read_placement(root.table("object"), installation.site);
  installation.landmarks = read_landmarks(root, installation.site);
  installation.contrast_landmarks = read_contrast_landmarks(
      root, installation.site,
      {installation.scene.width, installation.scene.height, &installation.scene, &installation.scene_distances_m});
  installation.cards = read_cards(root, installation.scene.width, installation.scene.height);
  return installation;
}

std::string calibration_summary(const Installation& installation, const std::filesystem::path& root_file) {
  const auto& adopted = installation.calibration;
  if (!adopted) return {};
  const auto name = adopted->file.filename().string();
  const auto date = [](const Camera& camera) {
    return camera.calibrated_utc ? utc_text(std::chrono::floor<std::chrono::seconds>(*camera.calibrated_utc))
                                 : std::string("an unknown date");
  };
  auto text = fmt::format("{}: the sky camera's of {}, the scene camera's of {}", name, date(installation.sky),
                          date(installation.scene));
  text += fmt::format("\n  from it: {}",
                      adopted->gained.empty() ? "nothing" : fmt::format("{}", fmt::join(adopted->gained, ", ")));
  if (!adopted->overruled.empty())
    text += fmt::format("\n  overridden by {}: {}", root_file.filename().string(), fmt::join(adopted->overruled, ", "));
  return text;
}

}  // namespace kasumi
