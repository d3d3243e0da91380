#include "calib/pose/azimuth_fit.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/square.hpp"

namespace kasumi {
namespace {

constexpr Radians kAgree = from_degrees(6.0);
constexpr Radians kLeastError = from_degrees(0.5);  // of one sun
constexpr Radians kOtherPlace = from_degrees(15.0);

// The azimuth of a picture's top by one sun; near the zenith it says little.
struct Turn {
  double azimuth = 0.0, weight = 0.0;
};

Direction turned(const Direction& direction, double azimuth) {
  return direction_from(zenith_angle(direction), azimuth_angle(direction) + Radians{azimuth});
}

struct Fit {
  double azimuth = 0.0;
  double square_sum = 0.0;  // of the angles left, of the suns that agree
  double weight = 0.0;
  std::vector<std::size_t> agree;
};

std::vector<std::size_t> agreeing(std::span<const SunPair> suns, double azimuth) {
  std::vector<std::size_t> agree;
  for (std::size_t i = 0; i < suns.size(); ++i)
    if (angle_between(turned(suns[i].seen, azimuth), suns[i].stood) < kAgree) agree.push_back(i);
  return agree;
}

Fit fit(std::span<const SunPair> suns) {
  std::vector<Turn> turns;
  for (const SunPair& sun : suns)
    turns.push_back({azimuth_angle(sun.stood).value - azimuth_angle(sun.seen).value,
                     square(std::sin(zenith_angle(sun.stood).value))});
  Fit best;
  for (const Turn& turn : turns)
    if (auto agree = agreeing(suns, turn.azimuth); agree.size() > best.agree.size())
      best = {turn.azimuth, 0.0, 0.0, std::move(agree)};
  double sine = 0.0, cosine = 0.0;
  for (const std::size_t i : best.agree) {
    sine += turns[i].weight * std::sin(turns[i].azimuth);
    cosine += turns[i].weight * std::cos(turns[i].azimuth);
    best.weight += turns[i].weight;
  }
  best.azimuth = std::atan2(sine, cosine);
  for (const std::size_t i : best.agree)
    best.square_sum += square(angle_between(turned(suns[i].seen, best.azimuth), suns[i].stood).value);
  return best;
}

bool at_two_places(std::span<const SunPair> suns, const std::vector<std::size_t>& agree) {
  return std::ranges::any_of(agree, [&](std::size_t i) {
    const double apart = azimuth_angle(suns[i].stood).value - azimuth_angle(suns[agree.front()].stood).value;
    return std::abs(std::remainder(apart, 2.0 * kPi)) > kOtherPlace.value;
  });
}

double mean_square(const Fit& fit) {
  return fit.square_sum / std::max<double>(1.0, static_cast<double>(fit.agree.size())) + square(kLeastError.value);
}

}  // namespace

std::optional<AzimuthFit> fit_azimuth(std::span<const SunPair> suns) {
  std::vector<SunPair> over(suns.begin(), suns.end());
  for (SunPair& sun : over) sun.seen = mirrored_in_picture(sun.seen);
  const Fit plain = fit(suns), mirror = fit(over);
  // More suns agree, or as many agree better.
  const bool mirrored = at_two_places(over, mirror.agree) &&
                        (mirror.agree.size() > plain.agree.size() ||
                         (mirror.agree.size() == plain.agree.size() && 4.0 * mean_square(mirror) < mean_square(plain)));
  const Fit& found = mirrored ? mirror : plain;
  if (found.agree.empty() || (suns.size() > 1 && found.agree.size() < 2)) return std::nullopt;
  AzimuthFit turn;
  turn.azimuth_up = Radians{found.azimuth < 0.0 ? found.azimuth + 2.0 * kPi : found.azimuth};
  turn.sigma = Radians{std::sqrt(mean_square(found) / std::max(found.weight, 0.05))};
  turn.mirrored = mirrored;
  turn.mirror_known = mirrored || at_two_places(suns, plain.agree);
  turn.suns = static_cast<int>(found.agree.size());
  return turn;
}

}  // namespace kasumi
