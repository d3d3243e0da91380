// What a picture is drawn under.
#pragma once

#include <memory>

#include "estimator/atmosphere.hpp"
#include "estimator/light/card_light.hpp"
#include "pipeline/show/scene/sky_watch.hpp"
#include "pipeline/site/visitor/building_view.hpp"

namespace kasumi {

// The air a picture is drawn under.
struct SceneConditions {
  AirState air;
  SunDirection sun{0, 0, 1};
  SkyCondition sky = SkyCondition::unknown;
  std::shared_ptr<const MeasuredSky> measured;  // the clouds; null: the sky model alone
  double past_hills = 1.0;                      // the share of the sun's disc that the skyline leaves to the object
  // Blur of the object by the haze in front of it (H Eq 7 at the object's range, lambda sqrt(optical depth)): standard
  // deviation in pixels. The fog of a valley is not counted.
  double haze_blur_px = 0.0;
  LightFactors by_cards{};                 // on the model's light
  double saturation = 1.0;                 // of the scene camera (calib/colour/camera_saturation)
  BuildingView view = BuildingView::live;  // of those that are lit or seen in another air; alone is as live
};

}  // namespace kasumi
