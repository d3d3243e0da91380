// The aerosol's kind, and the sky model that fits, over time.
#pragma once

#include <array>
#include <optional>

#include "base/clock.hpp"
#include "estimator/atmosphere.hpp"

namespace kasumi {

// A model that errs, errs in the next picture as well: probabilities are averaged over time, never multiplied. What is
// shown changes only when something else has become clearly likelier, since a visitor would see it go to and fro.
class KindBelief {
 public:
  using Kinds = std::array<double, kAerosolKinds.size()>;

  // What is given stays.
  explicit KindBelief(std::optional<AerosolKind> given = {}) : given_(given) {}

  // `by_sky`: by the sky camera; false: by the low sky, which counts only while there is no observation by the sky
  // camera.
  void observe(const FoundAerosol& found, bool by_sky, Instant when);
  void remember(AerosolKind kind, bool papers_sky, Instant when);

  AerosolKind shown() const;
  // The kind beside the shown one, and its share of the two's depth: of each, its excess over the uniform prior. 0
  // where there is none.
  struct Beside {
    AerosolKind kind = AerosolKind::continental;
    double share = 0.0;
  };
  Beside beside() const;
  bool papers_sky() const { return !given_ && papers_sky_; }
  Kinds kinds(Instant when) const;  // sum 1; uniform where nothing is known
  double papers_share() const { return given_ ? 0.0 : papers_share_; }

 private:
  std::optional<AerosolKind> given_;
  std::optional<Instant> seen_;
  std::optional<Instant> seen_above_;  // the sky above, last
  Kinds kinds_{};
  double papers_share_ = 0.0;
  AerosolKind shown_ = AerosolKind::continental;
  bool papers_sky_ = false;
};

}  // namespace kasumi
