// Whether the sun reaches the real ground, place by place, by the ground's brightness: the light of sun and sky there
// is known, the ground's reflectance is learned. A single brightness could be pale ground in the shade or dark ground
// in the sun; a reflectance that explains it under many suns decides. Kept per place are a distribution over the
// reflectance and the last seconds' brightness, of which only the median counts, so that passers-by leave no trace.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace kasumi {

// Of one place in one picture. Radiances in any common unit.
struct GroundSight {
  float radiance = 0.0f;  // the ground's own, without the air before it
  float sun = 0.0f;       // of a white surface there in full sun, the sun's part of it
  float sky = 0.0f;       // and the sky's
  float sigma = 0.0f;     // relative, of the radiance; 0: nothing was seen there
};

struct GroundGuess {
  float sunlit = 1.0f;  // share of the sun's light: the mean of what it may be
  float sigma = 0.0f;   // and how far that scatters
};

class GroundMemory {
 public:
  // A first estimate of each place's reflectance, 0..1, within a factor of 1.6.
  explicit GroundMemory(std::span<const float> reflectance);

  // One sight for each place. `at_s`: of the pictures' clock, in any order; only differences count.
  void see(std::span<const GroundSight> sights, double at_s);

  const std::vector<GroundGuess>& guesses() const { return guesses_; }
  double reflectance(std::size_t place) const;  // the median of what it may be

  // What was learnt, to be kept over a restart: kLearntBytes for each place, the shares' square roots over the largest.
  static constexpr std::size_t kLearntBytes = 96;
  std::vector<std::uint8_t> learnt() const;
  // Goes on from it; of the time since, which was not seen, as much is forgotten as if nothing had been learnt. false: of
  // another number of places, or damaged: nothing changes.
  bool resume(std::span<const std::uint8_t> learnt, double since_s);
  int lessons() const { return lessons_; }  // grows with what was learnt

 private:
  static constexpr int kSteps = static_cast<int>(kLearntBytes);  // of the reflectance, evenly spaced in its logarithm
  static constexpr int kLately = 5;                              // sights in the median
  using Shares = std::array<float, kSteps>;
  struct Place {
    Shares prior, now;                    // of the reflectance; each sums to 1
    std::array<float, kLately> lately{};  // brightness: radiance over sun + sky
    int seen = 0;
  };
  struct Likelihood {
    Shares of_step;
    GroundGuess guess;
  };
  static float reflectance_of(int step);
  Likelihood explain(const Shares& reflectance, const GroundSight& sight) const;
  static void learn(Place& place, const Shares& likelihood, double weight, double forgotten);

  std::vector<Place> places_;
  std::vector<GroundGuess> guesses_;
  std::optional<double> seen_at_s_, learned_at_s_;
  int lessons_ = 0;
};

}  // namespace kasumi
