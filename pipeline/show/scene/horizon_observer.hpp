// The horizon's light behind the building. Measuring it takes longer than drawing a picture, so it can be done
// separately, in any thread.
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "base/picture.hpp"
#include "calib/camera.hpp"
#include "capture/frame.hpp"
#include "estimator/horizon/horizon.hpp"
#include "estimator/light/card_light.hpp"
#include "estimator/sky/site_sky.hpp"
#include "gles/scene.hpp"
#include "pipeline/show/scene/ground_watch.hpp"
#include "pipeline/show/scene/scene_conditions.hpp"

namespace kasumi {

class HorizonObserver {
 public:
  HorizonObserver(Camera scene, Camera sky, DaylightModel sky_model, double altitude_m,
                  std::vector<LightCard> cards = {}, double ground_albedo = DaylightConditions{}.ground_albedo)
      : scene_(std::move(scene)),
        sky_(std::move(sky)),
        sky_model_(sky_model),
        altitude_m_(altitude_m),
        cards_(std::move(cards)),
        ground_albedo_(ground_albedo) {}

  const Camera& scene() const { return scene_; }
  // As the scene camera's picture shows it; where that shows no sky, by the sky camera's latest (`sky_picture`; may be
  // null), and at last by a model of the sky under `conditions` (may be null).
  HorizonLight observe(const PictureView& scene, const PictureView* sky_picture,
                       const SceneConditions* conditions) const;
  // What the cards say under `conditions`, one for each that can be read. Only before a horizon that the scene's picture
  // shows: others have no brightness of their own.
  std::vector<CardReading> read_cards(const PictureView& scene, const HorizonLight& horizon,
                                      const SceneConditions& conditions) const;

 private:
  HorizonLight modelled(const SceneConditions& conditions, const PictureView& scene) const;

  Camera scene_, sky_;
  DaylightModel sky_model_;
  double altitude_m_;
  std::vector<LightCard> cards_;
  double ground_albedo_;
};

// The render loop's request to the thread that measures.
struct HorizonQuestion {
  std::shared_ptr<const HorizonObserver> observer;
  FrameMetadata metadata;
  CopiedPicture picture;
  std::shared_ptr<const DecodedPicture> sky_picture;  // may be null
  SceneConditions conditions;
  PixelBox object_box{};                   // where the object appears; empty: not yet
  std::optional<GroundQuestion> ground{};  // of the same picture
};
struct HorizonAnswer {
  std::shared_ptr<const HorizonObserver> observer;  // that was asked
  FrameMetadata metadata;                           // of the picture
  HorizonLight seen;
  std::vector<CardReading> cards{};
  std::optional<AirlightGrid> behind{};        // light_behind()
  std::shared_ptr<const GroundWatch> watch{};  // that was asked; null: none
  GroundLook ground{};
};
HorizonAnswer answer(const HorizonQuestion& question);
// The same of a picture that stays where it is, the ground left out. `sky_picture` may be null.
HorizonAnswer answer(std::shared_ptr<const HorizonObserver> observer, const FrameMetadata& metadata,
                     const PictureView& picture, const PictureView* sky_picture, const SceneConditions& conditions,
                     const PixelBox& object_box);

}  // namespace kasumi
