// What is constant of the landmarks in one channel, solved together with the extinctions of all pictures that are kept
// (docs/physics.md 11): C = f + (C0 - f) exp(-beta d), one C0 and one f a landmark, one beta a picture.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace kasumi {

constexpr double kDarkest = 1.05;              // greatest C0: a camera that sharpens makes edges blacker than black
constexpr double kLeastContrastSigma = 0.006;  // of C0, however many pictures there are
constexpr double kLeastFloorSigma = 1e-4;      // of f, where it is said to be known

// Of n landmarks in one channel.
struct ContrastBelief {
  std::vector<double> mean, covariance;    // of C0, the contrast without air: n, and n x n by rows
  std::vector<double> floor, floor_sigma;  // of f: what is left of the contrast behind endless air
  std::vector<double> scatter;             // readings deviate by so many times what the law's spread says
};

// What one picture shows, for each landmark.
struct ChannelReading {
  double contrast = 0.0, sigma = 0.0;
  bool used = false;
};
struct ChannelSample {
  std::vector<ChannelReading> readings;
  std::optional<double> day;  // time, in days of any origin
};

// How surfaces and air deviate from that law. All are relative standard deviations.
struct ContrastSpread {
  double lit_each = 0.25;  // a surface's light in units of the sky's, from picture to picture, independently
  // The same for all surfaces at once: in the shade of a clear sky they return half of the share of the horizon's light
  // that they return under a closed one, at dawn a quarter.
  double lit_together = 0.5;
  double known_together = 0.5;  // share of the variance of ContrastLandmark::contrast_sigma that all have in common
  double patchy = 0.1;          // extinction of one path relative to another
  // In mist and fog ln(extinction) differs by so much elsewhere: of a meter's readings six to nine minutes apart, some
  // kilometre of drifting fog, 68 % are within e^.84 to e^.98 of each other, 95 % within e^1.7 to e^1.95 (shared data,
  // real-air/road). In haze it is hardly any.
  double fog_patchy = 0.9;
  double airlight = 0.03;  // the air on the way is brighter or darker than the light from infinity by this share
};

struct LawOfLandmark {
  double path_m = 0.0;
  bool before_sky = true;
};

// Variance of one reading under an optical depth, the common change of light excepted.
double variance_under(double depth, double contrast, double floor, double read_sigma, const LawOfLandmark& law,
                      const ContrastSpread& spread);

constexpr double kLitBy = 0.3;  // a surface in the sun returns so much more of the horizon's light

// Of one reading, off from the law by `off`: whether it follows the law, is of a surface in the sun, or neither.
struct Plausible {
  double usual = 1.0, lit = 0.0;  // probabilities
  double minus_two_log = 0.0;     // of its likelihood
};
Plausible plausible(double off, double variance, double kept, const LawOfLandmark& law);

// What pictures say of the constants (C0, then f) by themselves: the inverse covariance, 2n x 2n by rows, and that
// times the constants.
struct LearntConstants {
  std::vector<double> information, pull;
};

class JointChannel {
 public:
  // `clearest_per_m`: of air without any aerosol; `usual_aerosol_per_m`: what the median hour of a place has.
  JointChannel(std::vector<LawOfLandmark> laws, ContrastBelief prior, double clearest_per_m, double usual_aerosol_per_m,
               const ContrastSpread& spread = {});

  // From where it stands: cheap where little has changed. `most_steps`: of alternating; fewer where it has settled.
  void solve(const std::vector<ChannelSample>& pictures, int most_steps = 30);

  ContrastBelief belief() const { return belief_without(std::nullopt); }
  // As the other pictures have it, by which one of them can be judged. Without any picture the prior.
  ContrastBelief belief_without(std::optional<std::size_t> picture) const;
  // The same without the prior. Nothing before the first solution.
  LearntConstants learnt_without(std::optional<std::size_t> picture) const;
  // The likeliest of each picture; below `clearest_per_m` where the readings are.
  const std::vector<double>& per_m() const { return per_m_; }

 private:
  struct Information;
  double likeliest_per_m(const ChannelSample& picture) const;
  Information of(const ChannelSample& picture, double per_m) const;
  void add_clearest(const std::vector<ChannelSample>& pictures, std::vector<Information>& all);
  void scale_scatter(const std::vector<ChannelSample>& pictures);

  std::vector<LawOfLandmark> laws_;
  ContrastBelief prior_;
  double clearest_per_m_, usual_aerosol_per_m_;
  ContrastSpread spread_;
  std::vector<double> grid_per_m_;
  std::vector<double> kept_;       // exp(-beta d) by grid and landmark
  std::vector<double> constants_;  // C0, then f
  std::vector<double> scatter_;
  std::vector<double> per_m_;
  LearntConstants prior_information_, learnt_;  // of all pictures
  std::vector<LearntConstants> by_picture_;
};

}  // namespace kasumi
