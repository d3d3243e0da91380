// What the landmarks show about the air, and whether it agrees with the sky.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estimator/air/attenuation.hpp"
#include "estimator/landmarks/contrast_chroma.hpp"
#include "estimator/landmarks/contrast_tone.hpp"
#include "estimator/landmarks/extinction.hpp"
#include "estimator/landmarks/joint_channel.hpp"
#include "estimator/landmarks/path_aerosol.hpp"

namespace kasumi {

constexpr double kMeteorologicalRange = 3.912;         // ln 50: Koschmieder's 2 %, as visibility is elsewhere here
constexpr double kMeteorologicalOpticalRange = 2.996;  // ln 20: WMO's 5 %, as transmissometers and KNMI report it
constexpr double kDisagreement_sigmas = 3.0;           // one in 370 by chance

// The T whose air attenuates the camera's green channel as much over the landmarks' distances.
struct LandmarkTurbidity {
  std::optional<Turbidity> turbidity;  // nothing outside 1.7-20, where the scattering model ends
  double sigma = 0.0;
  std::string reason;  // why there is none
};

enum class Agreement { unknown, agrees, disagrees };
std::string_view name_of(Agreement agreement);

struct ChannelExtinctions {
  std::array<Extinction, 3> channels;  // R, G, B
  // Of the green channel, which is nearest to 550 nm.
  const Extinction& extinction() const { return channels[1]; }
  double visibility_m() const;  // 3.912 / extinction; for a bound, the bound
  double visibility_sigma_m() const;
  double optical_range_m() const;  // MOR, 2.996 / extinction; for a bound, the bound
  LandmarkTurbidity turbidity;
  PathAerosol aerosol{};    // by all channels at once
  ContrastChroma camera{};  // by all pictures so far
  ContrastTone tone{};      // the same
  std::string doubt{};      // for people: near and far do not agree; sigma holds it
};

// What one picture showed, to be kept.
struct KeptReadings {
  std::vector<ContrastReading> readings;  // one for each landmark
  std::optional<double> day;              // its time, in days of any one origin
};

// Comparison with the sky's T. The two are never averaged: two numbers, and how far apart they are.
struct ExtinctionComparison {
  Agreement agreement = Agreement::unknown;
  double sky_per_m = 0.0, sky_sigma_per_m = 0.0;  // extinction that corresponds to the sky's T here
  double sigmas = 0.0;  // (landmarks' - sky's) over both sigmas; 0 within a bound, beyond it the distance from it
  std::string message;  // for people
};

// Extinction of a level path in the camera's channels: -ln of the transmittance, per metre.
glm::dvec3 model_extinction_per_m(const AttenuationNodes& nodes, ScatteringModel model, Turbidity turbidity,
                                  double altitude_m, double path_m);

// One camera's landmarks.
class LandmarkWatch {
 public:
  LandmarkWatch(const Camera& camera, double altitude_m, std::vector<ContrastLandmark> landmarks,
                const ContrastSpread& spread = {}, ScatteringModel model = ScatteringModel::morales2017);

  const std::vector<ContrastLandmark>& landmarks() const { return landmarks_; }
  // The horizon is measured if a landmark has no sky box. Of pictures by night or in infrared light (daylight.hpp) none
  // is usable. `sun`: where known.
  std::vector<ContrastReading> read(const Camera& camera, const Image<glm::vec3>& encoded,
                                    const std::optional<Direction>& sun = {}) const;

  // With the landmarks' constants as learnt so far. At least 300 times faster than a solution.
  ChannelExtinctions estimate(const std::vector<ContrastReading>& readings) const;
  // Keeps the picture among the last kMostKept, and solves for what is constant of the landmarks in all of them. One that
  // shows what the last one does stands in its place: an unchanged scene is one reading.
  void learn(const std::vector<ContrastReading>& readings, std::optional<double> day = {});
  const std::vector<KeptReadings>& kept() const { return kept_; }
  // The camera's response at a quarter, half and three quarters of full scale, in units of it. By another response the
  // same picture has other contrasts.
  const std::array<glm::dvec3, 3>& response() const { return response_; }
  // Continues with what was kept. false, with nothing changed, if it is of other landmarks.
  bool resume(std::vector<KeptReadings> kept);
  // Solves all pictures of one camera together, then estimates each with constants learnt from the others. `left_out`:
  // landmarks excluded from solution and answers, so that the estimate of the air before them is independent of their
  // own readings.
  std::vector<ChannelExtinctions> estimate_all(const std::vector<std::vector<ContrastReading>>& pictures,
                                               std::span<const std::size_t> left_out = {}) const;

  // Chosen: more would see more hours and slow the joint solution, fewer forget the clearest ones.
  static constexpr std::size_t kMostKept = 200;

  ExtinctionComparison compare(const ChannelExtinctions& air, Turbidity sky, double sky_sigma) const;
  const LandmarkExtinction& channel(int c) const { return channels_[static_cast<std::size_t>(c)]; }
  const LandmarkColours& colours() const { return colours_; }
  // By all pictures that are kept.
  const ContrastChroma& chroma() const { return chroma_; }
  const ContrastTone& tone() const { return tone_; }

 private:
  // Unusable where the sky is none, lit where their colours say so, as far as they are known.
  std::vector<ContrastReading> judged(std::vector<ContrastReading> readings) const;
  void solve(const std::vector<KeptReadings>& pictures, int most_steps);
  void believe(std::optional<std::size_t> without);
  ChannelExtinctions agreed(ChannelExtinctions air, const std::vector<ContrastReading>& readings) const;
  ChannelExtinctions with_turbidity(std::array<Extinction, 3> channels, PathAerosol aerosol) const;

  std::vector<ContrastLandmark> landmarks_;
  std::array<glm::dvec3, 3> response_;
  double altitude_m_;
  ContrastSpread spread_;
  ScatteringModel model_;
  AttenuationNodes nodes_;
  double typical_path_m_;
  glm::dvec3 usual_per_m_{0.0};  // extinction of the median hour
  std::vector<LandmarkExtinction> channels_;
  std::vector<JointChannel> joint_;
  LandmarkColours colours_;
  ContrastChroma chroma_;
  ContrastTone tone_;
  std::vector<KeptReadings> kept_;
};

}  // namespace kasumi
