// Renders photographs under other air, from the camera, the light paths and the two airs.
#pragma once

#include <optional>
#include <string>

#include "base/photograph.hpp"
#include "base/result.hpp"
#include "calib/camera.hpp"
#include "estimator/horizon/horizon.hpp"
#include "estimator/photograph/retarget.hpp"

namespace kasumi {

struct SourceConditions {
  Camera camera;  // of the pictures
  double altitude_m = 0.0;
  std::optional<SunDirection> sun;  // empty: nothing that depends on the sun is changed
  AirState source;                  // the pictures' own air
  Image<float> distance_m;          // at the pictures' size; empty: `everything_at_m`, and sky where sky is found
  std::optional<double> everything_at_m;
  // Nothing was measured: distances and the light from infinity are estimated from each picture's own haze
  // (estimator/photograph/depth_from_haze), which is taken to be grey, or of the source's exponent.
  bool from_haze = false;
  bool grey_from_haze = true;
  bool find_sky = false;               // find sky in each picture, whatever `distance_m` says about it
  double horizon_weight = 1.0;         // of a picture's own horizon; the rest is that of the previous pictures
  std::optional<glm::dvec3> airlight;  // linear, 0..1 of full scale; empty: each picture's own horizon
  // Light from infinity under the target's air: given, or from a picture taken under it; otherwise what the sky model
  // predicts from the source's.
  std::optional<glm::dvec3> target_airlight;
  std::optional<HorizonLight> target_horizon;
  // With the sky model: keep the source's exposure; otherwise keep the horizon's brightness, as automatic exposure
  // would.
  bool same_exposure = false;
  std::optional<ScatteringModel> scattering;  // empty: the aerosol's own where it is known, else morales2017
  bool relight = true;         // false: surfaces keep their light in units of the light from infinity, as in M Eq 25
  bool amplify_noise = false;  // treat noise as light of the scene
  double largest_gain = RetargetLimits{}.largest_gain;
  bool terms = false;  // also give airlight and direct transmission apart
};

struct UnderOtherAir {
  Photograph picture;
  Image<std::uint8_t> restored;  // 255; 0 where the source was too faint
  double too_faint_fraction = 0.0;
  // With `terms`, in 16 bits: in linear light they add up to the picture where it is not overexposed.
  std::optional<Photograph> airlight{}, direct{};
};

// A camera for an ordinary photograph: no distortion, sRGB, facing north.
Camera plain_camera(int width, int height, Radians field_of_view, Radians pitch);

// The horizon in a photograph. Errors: bad_input (with the reason).
Result<HorizonLight> horizon_of(const Camera& camera, const Photograph& photograph, const std::string& name);

// One picture at a time; what depends only on the camera is kept.
class OtherAir {
 public:
  explicit OtherAir(SourceConditions options);
  // Sets the picture that the following calls of `under` change. Errors: bad_input (size, no horizon, no sky).
  Result<> set_picture(Photograph photograph, const std::string& name);
  // Nothing: without any air.
  UnderOtherAir under(const std::optional<AirState>& target) const;

 private:
  void guess_from_haze(const Photograph& photograph);
  // Estimates its noise, and its sunlit and shaded parts.
  void separate(const Photograph& photograph);
  // Light from infinity of the current picture, or as the target's options say.
  Image<glm::vec3> from_infinity(const std::optional<glm::dvec3>& given, const HorizonLight* horizon,
                                 const AirState& air) const;
  Image<glm::vec3> targets(const std::optional<AirState>& target) const;

  SourceConditions options_;
  ScatteringModel scattering_;
  AttenuationNodes nodes_;
  Image<float> rise_;
  double quantum_ = 0.0;
  Image<glm::vec3> light_;
  RetargetGeometry depth_;
  RetargetAir source_;
  RetargetHints parts_;
  std::optional<HorizonLight> horizon_;
};

}  // namespace kasumi
