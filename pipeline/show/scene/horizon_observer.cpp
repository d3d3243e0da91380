#include "pipeline/show/scene/horizon_observer.hpp"

#include "calib/colour/colorimetry.hpp"
#include "pipeline/show/scene/light_behind.hpp"

namespace kasumi {

HorizonLight HorizonObserver::observe(const PictureView& scene, const PictureView* sky_picture,
                                      const SceneConditions* conditions) const {
  auto seen = measure_horizon(scene_, scene);
  if (!seen.usable() && sky_picture) seen = horizon_from_sky_camera(sky_, *sky_picture, scene_, scene);
  if (!seen.usable() && conditions) seen = modelled(*conditions, scene);
  return seen;
}

HorizonLight HorizonObserver::modelled(const SceneConditions& conditions, const PictureView& scene) const {
  if (conditions.sky == SkyCondition::overcast) {
    const glm::dvec3 grey = srgb_to_xyz() * glm::dvec3{1.0};
    return horizon_from_model([&](const Direction&) { return grey; }, scene_, scene);
  }
  const SiteSky sky(sky_model_, conditions.air, conditions.sun, altitude_m_);
  return horizon_from_model([&](const Direction& view) { return sky.relative_xyz(view); }, scene_, scene);
}

std::vector<CardReading> HorizonObserver::read_cards(const PictureView& scene, const HorizonLight& horizon,
                                                     const SceneConditions& conditions) const {
  std::vector<CardReading> readings;
  if (cards_.empty() || horizon.source != HorizonLight::Source::scene_camera) return readings;
  const Daylight daylight(
      scene_, conditions.air, conditions.sun,
      {conditions.sky, ground_albedo_, altitude_m_, sky_model_, conditions.measured.get(), conditions.past_hills});
  for (const LightCard& card : cards_)
    if (const auto seen = card_over_horizon(card, scene_, scene, horizon, conditions.saturation))
      readings.push_back(card_reading(card, *seen, towards_card(card, scene_, horizon), daylight));
  return readings;
}

HorizonAnswer answer(std::shared_ptr<const HorizonObserver> observer, const FrameMetadata& metadata,
                     const PictureView& picture, const PictureView* sky_picture, const SceneConditions& conditions,
                     const PixelBox& object_box) {
  HorizonAnswer made{std::move(observer), metadata, {}};
  made.seen = made.observer->observe(picture, sky_picture, &conditions);
  made.cards = made.observer->read_cards(picture, made.seen, conditions);
  made.behind = light_behind(made.observer->scene(), picture, object_box, made.seen);
  return made;
}

HorizonAnswer answer(const HorizonQuestion& question) {
  const auto* sky = question.sky_picture ? &question.sky_picture->view() : nullptr;
  HorizonAnswer made = answer(question.observer, question.metadata, question.picture.view(), sky, question.conditions,
                              question.object_box);
  if (!question.ground) return made;
  GroundWatch& watch = *question.ground->watch;
  watch.see(question.picture.view(), question.metadata, *question.ground->appearance, question.ground->measured);
  watch.shade_foot(false);
  made.watch = question.ground->watch;
  made.ground = watch.look();
  return made;
}

}  // namespace kasumi
