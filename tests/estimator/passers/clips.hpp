// Generated clips of people, birds and cars before the place of a building, and what a watch finds in them.
#pragma once

#include <functional>
#include <map>

#include "capture/codec/encode.hpp"
#include "estimator/passers/passers.hpp"
#include "tests/fixtures/in_front/lit_land.hpp"

namespace kasumi {

constexpr int kClipWidth = 320, kClipHeight = 180;

// The place of a building: a hall with a tower on it.
inline bool is_building(int x, int y) {
  return (x >= 60 && x < 270 && y >= 105 && y < 145) || (x >= 125 && x < 195 && y >= 35 && y < 105);
}

// What stands before it at an instant; empty: nothing.
using Before = std::function<void(fixtures::Cutout&, double seconds)>;

// What a picture's outline misses and takes too much of.
struct OutlineErrors {
  double passer_px = 0.0;   // that stand before the building
  double drawn_over = 0.0;  // share of them
  double halo = 0.0;        // pixels of the building that were left out though nobody covers them, over passer_px
  double false_px = 0.0;    // the same, in pixels
  double building_px = 0.0;
};

class Clip {
 public:
  explicit Clip(const fixtures::LitLandSettings& settings) : land_(settings) {}

  // The film's JPEG at that quality, as a camera delivers it; 100: uncompressed.
  int jpeg_quality = 92;
  // What a camera or the weather does to a picture afterwards.
  std::function<void(Image<Rgb8>&, double seconds)> spoil;

  const PassersLook& show(Passers& watch, double seconds, const Before& before = {});
  // Of the picture shown last.
  OutlineErrors errors(const PassersLook& look) const;
  const Image<Rgb8>& picture() const { return picture_; }
  const fixtures::LitLand& land() const { return land_; }

 private:
  fixtures::LitLand land_;
  std::map<double, Image<Rgb8>> empty_;  // filmed before, by their seconds: most of the time goes into that
  fixtures::Cutout cutout_;
  Image<Rgb8> picture_;
};

// The part that a watch of this building looks at.
inline Passers watch_of_building(
    const Response& response = fixtures::scene_camera({.tone_curve = true}).camera.response) {
  return Passers(part_around(60, 35, 270, 145, 32, kClipWidth, kClipHeight), response);
}
constexpr Instant at(double seconds) {
  return Instant{} + std::chrono::duration_cast<Duration>(std::chrono::duration<double>(100.0 + seconds));
}

// Shows the empty scene for the first `seconds`, a picture every `period_s`.
void settle(Clip& clip, Passers& watch, double seconds, double period_s = 4.0);

}  // namespace kasumi
