// People, birds and vehicles before the building, found in each picture of the scene camera by comparison with the
// scene without them in the same light. Only the scene without them is kept, in memory (SceneMemory).
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "base/clock.hpp"
#include "estimator/passers/expected_scene.hpp"
#include "estimator/passers/passer_outline.hpp"
#include "estimator/passers/picture_part.hpp"

namespace kasumi {

enum class PassersState {
  watching,
  learning,  // the scene without passers is not known yet: none are kept in front
  dark,      // too dark to detect passers
  unsettled  // more of the picture is another than people cover: new light, a bumped camera; learnt soon
};
std::string_view name_of(PassersState state);    // for the status: "watching"
std::string_view reason_of(PassersState state);  // for people; empty while watching

struct PassersLook {
  PassersState state = PassersState::learning;
  double known_share = 0.0;    // of the part's cells, whose expected light is known
  Duration until_watching{};   // at least, while learning
  double covered_share = 0.0;  // of the part's cells
  PassersInFront in_front;
};

// Belongs to one thread.
class Passers {
 public:
  Passers() = default;
  // `place`: the building's box with a margin, in which the light around it is seen.
  explicit Passers(const PartPlace& place, const Response& response = Response::srgb())
      : place_(place), tone_(response), expected_(place, tone_), covered_(place.columns(), place.rows(), 0) {}

  // Of the scene camera's next picture, which must hold the place.
  const PassersLook& look(const PictureView& picture, Instant captured_at);
  const PassersLook& last() const { return last_; }
  const PartPlace& place() const { return place_; }
  const ExpectedScene& expected() const { return expected_; }

 private:
  void find_covered(const Image<float>& score);
  void forget();

  PartPlace place_;
  Tone tone_;
  PicturePart part_;
  ExpectedScene expected_;
  Image<std::uint8_t> covered_;
  std::optional<Instant> before_;                  // the picture before
  std::optional<Instant> unsettled_since_, seen_;  // seen: a picture that was bright enough
  PassersLook last_;
};

}  // namespace kasumi
