// What the landmarks say of the air, and whether the sky says the same.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "estimator/air/attenuation.hpp"
#include "estimator/landmarks/extinction.hpp"

namespace kasumi {

constexpr double kMeteorologicalRange = 3.912;         // ln 50: Koschmieder's 2 %, as visibility is elsewhere here
constexpr double kMeteorologicalOpticalRange = 2.996;  // ln 20: WMO's 5 %, as transmissometers and KNMI report it
constexpr double kDisagreement_sigmas = 3.0;

// T whose air takes as much from the camera's green channel over the landmarks' distances.
struct LandmarkTurbidity {
  std::optional<Turbidity> turbidity;  // nothing outside 1.7-20, where the scattering model ends
  double sigma = 0.0;
  std::string reason;  // why nothing
};

enum class Agreement { unknown, agrees, disagrees };
std::string_view name_of(Agreement agreement);

struct LandmarkAir {
  std::array<Extinction, 3> channels;  // R, G, B
  // Of the green channel, nearest to 550 nm.
  const Extinction& extinction() const { return channels[1]; }
  double visibility_m() const;  // 3.912 / extinction; of a bound the bound
  double visibility_sigma_m() const;
  double optical_range_m() const;  // MOR, 2.996 / extinction; of a bound the bound
  LandmarkTurbidity turbidity;
};

// How the sky's T compares. Never an average: two numbers, and how far apart they are.
struct SkyComparison {
  Agreement agreement = Agreement::unknown;
  double sky_per_m = 0.0, sky_sigma_per_m = 0.0;  // extinction that the sky's T means here
  double sigmas = 0.0;  // (landmarks' - sky's) over both sigmas; 0 within a bound, beyond it the distance from it
  std::string words;    // for a person
};

// Extinction of a level path in the camera's channels: -ln of what is left, per metre.
glm::dvec3 model_extinction_per_m(const AttenuationNodes& nodes, ScatteringModel model, Turbidity turbidity,
                                  double altitude_m, double path_m);

// One camera's landmarks.
class LandmarkWatch {
 public:
  LandmarkWatch(const Camera& camera, double altitude_m, std::vector<ContrastLandmark> landmarks,
                const ContrastSpread& spread = {}, ScatteringModel model = ScatteringModel::morales2017);

  const std::vector<ContrastLandmark>& landmarks() const { return landmarks_; }
  // The horizon is measured where a landmark has no sky box.
  std::vector<ContrastReading> read(const Camera& camera, const Image<glm::vec3>& encoded) const;

  LandmarkAir look(const std::vector<ContrastReading>& readings) const;
  void learn(const std::vector<ContrastReading>& readings);
  void forget(double share);
  // Of R, G, B. resume() takes all or nothing: false.
  std::vector<LearntContrasts> learnt() const;
  bool resume(const std::vector<LearntContrasts>& learnt);
  // Pictures of one camera at once, each judged with what the others tell of the contrasts.
  std::vector<LandmarkAir> look_at_all(const std::vector<std::vector<ContrastReading>>& pictures) const;

  SkyComparison compare(const LandmarkAir& air, Turbidity sky, double sky_sigma) const;
  const LandmarkExtinction& channel(int c) const { return channels_[static_cast<std::size_t>(c)]; }

 private:
  LandmarkAir with_turbidity(std::array<Extinction, 3> channels) const;

  std::vector<ContrastLandmark> landmarks_;
  double altitude_m_;
  ScatteringModel model_;
  AttenuationNodes nodes_;
  double typical_path_m_;
  std::vector<LandmarkExtinction> channels_;
};

}  // namespace kasumi
