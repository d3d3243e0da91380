// Today's air between the scene camera and the object: turns T and the visible horizon into what the renderer needs.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "capture/frame.hpp"
#include "estimator/air/attenuation.hpp"
#include "estimator/horizon/horizon.hpp"
#include "estimator/light/airlight.hpp"
#include "estimator/light/object_light.hpp"
#include "estimator/light/skyline.hpp"
#include "gles/scene.hpp"
#include "pipeline/show/scene/horizon_observer.hpp"
#include "pipeline/show/scene/scene_conditions.hpp"

namespace kasumi {

struct AirRendering {
  // Empty: the aerosol's own where it is known and the sky is the dome, else morales2017.
  std::optional<ScatteringModel> scattering{};
  ZetaForm zeta = ZetaForm::full;
  bool aerial_perspective = true;        // false: the "before" picture
  bool black_object = false;             // neither sun nor sky reach it: what is seen there is airlight
  std::optional<Turbidity> turbidity{};  // instead of the air that was found
  // Before the first report of the air: an ordinary clear day.
  Turbidity until_known{3.0};
  Duration horizon_interval = std::chrono::seconds(1);  // between measurements of the horizon
};

// What the cards in view say.
struct CardsLook {
  LightFactors factors;            // on the model's light, as it is drawn
  std::size_t in_view = 0;         // cards in view
  std::size_t read = 0;            // cards that could be read in the last picture examined
  std::optional<Instant> read_at;  // when one was last; of the pictures' clock
};

// Whether a layer drawn under the one looks the same under the other.
bool look_alike(const SceneConditions& now, const SceneConditions& drawn);

class SceneAir {
 public:
  SceneAir(const Installation& installation, AirRendering options);

  SceneConditions conditions(const SkyReport& report) const;
  // The same for a view of the building. `report`: lit for it (lit_for()).
  SceneConditions conditions(const SkyReport& report, BuildingView view) const;
  // Haze, light and the model's horizon over the object's part of the picture. `box`: where the object appears. With a
  // ground that was looked at it BLOCKS for some milliseconds.
  ObjectAppearance appearance(const SceneConditions& conditions, const PixelBox& box,
                              const GroundLook& ground = {}) const;
  // Measured light from infinity in the scene camera's linear light, and its saturation; a plain grey of 0.5 while no
  // horizon is known.
  AirlightGrid measured(const SceneConditions& conditions, const PixelBox& box) const;

  // With each frame. The horizon follows the camera's exposure; it is measured again, in any thread, once per
  // horizon_interval of recorded time: a frame is asked for by horizon_is_due() and asked(), and adopted when it comes.
  void follow_exposure(const FrameMetadata& metadata);
  bool horizon_is_due(const FrameMetadata& metadata) const;
  void asked(const FrameMetadata& metadata) { horizon_asked_at_ = metadata.captured_at; }
  void adopt(const HorizonAnswer& answer);  // one to another observer is left
  const std::shared_ptr<const HorizonObserver>& observer() const { return observer_; }
  const HorizonLight& horizon() const { return horizon_; }
  std::optional<CardsLook> cards() const;  // empty: there are none

 private:
  AirState air_under(const SkyReport& report) const;
  ScatteringModel scattering(const AirState& air) const;
  HazeCoefficients haze(const AirState& air) const;
  double haze_blur_px(const AirState& air) const;
  // Factor on the light from infinity by direction, as the model has it and as measured alike (FinitePath).
  std::function<glm::dvec3(const Direction&)> air_before_object(const SceneConditions& conditions) const;
  void adopt(HorizonLight seen, const FrameMetadata& metadata);
  void adopt(const std::vector<CardReading>& cards, const FrameMetadata& metadata);
  void adopt(const std::optional<AirlightGrid>& behind, const FrameMetadata& metadata);
  glm::dvec3 most_before_object(const glm::dvec2& pixel, const HorizonLight& horizon, const Direction& direction,
                                const glm::dvec3& left) const;
  const Camera& scene() const { return observer_->scene(); }

  std::shared_ptr<const HorizonObserver> observer_;
  double altitude_m_;
  double ground_albedo_;
  bool shadows_;
  std::optional<double> saturation_;  // of the camera; empty: it is learnt
  Skyline skyline_;
  DaylightModel sky_model_;
  GivenAir given_;
  FogLayer fog_;
  double blur_of_depth_1_px_;
  OpticalPath to_object_;
  double to_object_m_;  // over the ground
  AirRendering options_;
  SpectralMeasure measure_;
  // Of the air last asked for; the aerosol's move with its exponent.
  struct Nodes {
    ScatteringModel scattering = ScatteringModel::morales2017;
    double angstrom_exponent = 0.0;  // read where the aerosol scatters
    AttenuationNodes nodes;
  };
  mutable std::optional<Nodes> nodes_;
  // By cards of known reflectance, over minutes; without any the model's own.
  CardsLook cards_;
  std::optional<Instant> cards_followed_at_;
  std::optional<AirlightGrid> behind_;  // light_behind(), over a minute; empty: not seen
  std::optional<Instant> behind_seen_at_;
  HorizonLight horizon_;
  std::optional<Instant> horizon_seen_at_, horizon_asked_at_;
  std::optional<double> exposure_;  // of the last frame: seconds times gain
};

}  // namespace kasumi
