#include "pipeline/show/scene/scene_watch.hpp"

#include "base/picture.hpp"
#include "estimator/fusion/horizon_column.hpp"

namespace kasumi {

namespace {

constexpr Duration kLearnInterval = std::chrono::minutes(30);  // until surfaces are lit differently
constexpr double kLowestSun = 0.087;  // sine of 5 degrees: below, land and horizon are lit differently

Image<glm::vec3> encoded_of(const PictureView& view) {
  const Image<Rgb8> picture = to_rgb(view);
  Image<glm::vec3> encoded(picture.width(), picture.height());
  for (std::size_t i = 0; i < encoded.elements().size(); ++i)
    encoded.elements()[i] = glm::vec3(picture.elements()[i]) / 255.0F;
  return encoded;
}

// By which T and extinction belong together: M's T means far more extinction in blue than the air has.
ScatteringModel law_of(DaylightModel model) {
  return model == DaylightModel::preetham ? ScatteringModel::morales2017 : ScatteringModel::aerosol;
}

// A closed cover of clouds may be as smooth as a clear sky.
bool may_be_clear(SkyCondition sky) {
  return sky == SkyCondition::clear || sky == SkyCondition::partly_cloudy || sky == SkyCondition::unknown ||
         sky == SkyCondition::covered_lens;
}

double days(Instant when) {
  return to_seconds(when.time_since_epoch()) / 86400.0;
}

}  // namespace

void SceneWatch::has_learnt(Instant when) {
  learnt_ = when;
  const auto& kept = landmarks_.kept();
  if (!kept.empty() && kept.back().day) first_day_ = *kept.back().day - days(when);
}

SceneWatch::SceneWatch(const Installation& installation)
    : camera_(installation.scene),
      sky_(installation.model_to_fit()),
      reads_low_sky_(installation.surroundings.sky_model != DaylightModel::preetham &&
                     !installation.surroundings.air.whole()),
      landmarks_(installation.scene, installation.site.altitude_m, installation.contrast_landmarks, {},
                 law_of(installation.surroundings.sky_model)) {}

SceneLook SceneWatch::look(const PictureView& picture, Instant when, const DaylightState& above) {
  SceneLook look;
  look.air.when = when;
  if (above.sun && above.sun->z < kLowestSun) {
    look.reason = "the sun is too low: land and horizon are lit differently";
    return look;
  }
  if (reads_low_sky_ && above.sun && may_be_clear(above.sky))
    look.air.low_sky = column_by_horizon(camera_, picture, *above.sun, sky_).reading;
  if (!has_landmarks()) return look;
  auto readings = landmarks_.read(camera_, encoded_of(picture));
  if (above.sun && above.sky != SkyCondition::overcast) mark_lit(landmarks_.landmarks(), *above.sun, readings);
  look.landmarks = landmarks_.estimate(readings);
  look.reason =
      look.landmarks->extinction().reason.empty() ? look.landmarks->doubt : look.landmarks->extinction().reason;
  look.air.path = landmarks_.colours().reading_of(look.landmarks->aerosol);
  if (landmarks_.chroma().known()) look.air.saturation = saturation_believed(landmarks_.chroma());
  if (learnt_ && when - *learnt_ < kLearnInterval) return look;
  learnt_ = when;
  landmarks_.learn(readings, days(when) + first_day_);
  look.learnt = true;
  return look;
}

}  // namespace kasumi
