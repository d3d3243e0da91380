#include "estimator/turbidity/colour_statistics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <opencv2/core.hpp>

#include "base/statistics.hpp"
#include "estimator/turbidity/clear_form.hpp"
#include "estimator/turbidity/element_maps.hpp"

namespace kasumi {

namespace {

// The sky in cells of about 1 deg, whatever the picture's size.
struct Cells {
  cv::Mat1f known, luminance, colour;  // 1 or 0; ln Y, ln R/B
  Image<glm::vec3> direction;
};
Cells cells_of(const ElementGeometry& geometry, const ElementLight& light) {
  constexpr double kAcross = 160.0;  // cells: a cloud is several, and noise averages out
  const int width = light.use.width(), height = light.use.height();
  const int side = std::max(1, static_cast<int>(std::lround(std::max(width, height) / kAcross)));
  const cv::Mat1f none(height / side, width / side, 0.0f);
  Cells cells{none.clone(), none.clone(), none.clone(), Image<glm::vec3>(none.cols, none.rows)};
  for (int y = 0; y < none.rows; ++y)
    for (int x = 0; x < none.cols; ++x) {
      glm::vec3 sum{0.0f}, direction{0.0f};
      float log_y = 0.0f;
      int clear = 0;
      for (int j = y * side; j < (y + 1) * side; ++j)
        for (int i = x * side; i < (x + 1) * side; ++i) {
          if (light.use.at(i, j) != PixelUse::clear) continue;
          sum += light.light.at(i, j);
          direction += geometry.direction.at(i, j);
          log_y += light.log_luminance.at(i, j);
          ++clear;
        }
      if (2 * clear < side * side || !(sum.r > 0.0f && sum.b > 0.0f)) continue;
      cells.known(y, x) = 1.0f;
      cells.luminance(y, x) = log_y / static_cast<float>(clear);
      cells.colour(y, x) = std::log(sum.r / sum.b);
      cells.direction.at(x, y) = glm::normalize(direction);
    }
  return cells;
}

struct Place {
  glm::vec3 direction;
  float luminance, colour, texture;
};
std::vector<Place> sky_places(const Cells& cells) {
  constexpr int kApart = 3;  // every third cell: neighbours say the same
  const cv::Mat1f texture = texture_of(cells.luminance, cells.known);
  const cv::Mat1f luminance = mean_over(cells.luminance, cells.known, kApart);
  const cv::Mat1f colour = mean_over(cells.colour, cells.known, kApart);
  std::vector<Place> places;
  for (int y = 0; y < cells.known.rows; y += kApart)
    for (int x = 0; x < cells.known.cols; x += kApart)
      if (cells.known(y, x) != 0.0f)
        places.push_back({cells.direction.at(x, y), luminance(y, x), colour(y, x), texture(y, x)});
  return places;
}

// ln R/B over that of the bluest sky at the same height and distance from the sun: over a smooth lower envelope, from
// least squares in which what is whiter hardly counts.
std::vector<float> whiter_than_bluest(const std::vector<Place>& places, const SunDirection& sun) {
  // Of the smooth envelope below; what is whiter than it weighs 3 %, so that the envelope runs along the bluest places.
  constexpr int kColourTerms = 6, kRounds = 12;
  constexpr double kWhiter = 0.03, kStiffness = 1e-5;
  const glm::vec3 towards_sun(sun);
  cv::Mat1d terms(static_cast<int>(places.size()), kColourTerms);
  for (int i = 0; i < terms.rows; ++i) {
    const glm::vec3& direction = places[static_cast<std::size_t>(i)].direction;
    const double cosine = std::clamp(static_cast<double>(glm::dot(direction, towards_sun)), -1.0, 1.0);
    const double up = static_cast<double>(direction.z), gamma = std::acos(cosine);
    const std::array here{1.0, 0.2 / (up + 0.1), up, std::exp(-3.0 * gamma), std::exp(-8.0 * gamma), cosine};
    for (int k = 0; k < kColourTerms; ++k) terms(i, k) = here[static_cast<std::size_t>(k)];
  }
  std::vector<float> whiter(places.size(), -1.0f);
  for (int round = 0; round < kRounds; ++round) {
    cv::Mat1d a(kColourTerms, kColourTerms, 0.0), b(kColourTerms, 1, 0.0), factors, bluest;
    cv::setIdentity(a, kStiffness * terms.rows);
    for (int i = 0; i < terms.rows; ++i) {
      const auto place = static_cast<std::size_t>(i);
      const double weight = whiter[place] > 0.0f ? kWhiter : 1.0;
      for (int k = 0; k < kColourTerms; ++k) {
        b(k, 0) += weight * terms(i, k) * static_cast<double>(places[place].colour);
        for (int l = 0; l < kColourTerms; ++l) a(k, l) += weight * terms(i, k) * terms(i, l);
      }
    }
    cv::solve(a, b, factors, cv::DECOMP_CHOLESKY);
    cv::gemm(terms, factors, 1.0, cv::noArray(), 0.0, bluest);
    for (int i = 0; i < terms.rows; ++i)
      whiter[static_cast<std::size_t>(i)] =
          places[static_cast<std::size_t>(i)].colour - static_cast<float>(bluest(i, 0));
  }
  return whiter;
}

// The part of the sky that agrees with one clear form is begun with its bluest and evenest places.
void compare_with_form(ColourStatistics& look, const std::vector<Place>& places, const SunDirection& sun) {
  constexpr float kAir = 0.12f, kEven = 0.06f, kPerhapsCloud = 0.02f;                    // to begin with
  constexpr float kLuminance = 0.12f, kColour = 0.08f, kTexture = 0.08f, kDark = -0.8f;  // of what agrees; of no sky
  constexpr float kWhiter = 0.15f;  // of ln R/B over the bluest: chosen between haze and thin cloud
  const ClearForm form(sun);
  const std::vector<float> whiter = whiter_than_bluest(places, sun);
  std::vector<LookedAt> looked_at;
  looked_at.reserve(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place& p = places[i];
    const bool air = whiter[i] < kAir && p.texture < kEven;
    looked_at.push_back({form.at(p.direction), p.luminance, p.colour, air ? 1.0f : kPerhapsCloud});
  }
  const auto sky = fit_clear_form(looked_at);
  if (!sky) {
    look.cover = static_cast<double>(std::ranges::count_if(whiter, [](float w) { return w > kWhiter; })) /
                 static_cast<double>(places.size());
    return;
  }
  int agreeing = 0, other = 0, white = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const LookedAt& p = looked_at[i];
    const float darker = p.luminance - sky->luminance_at(p.terms), redder = p.colour - sky->colour_at(p.terms);
    if (std::abs(darker) < kLuminance && std::abs(redder) < kColour && places[i].texture < kTexture) {
      ++agreeing;
    } else if (darker > kDark) {
      ++other;
      if (whiter[i] > kWhiter) ++white;
    }
  }
  const double sky_places = std::max(1, agreeing + other);
  look.smooth = agreeing / sky_places;
  look.cover = white / sky_places;
}

ColourStatistics colours_of_places(const std::vector<Place>& places, const SkyPicture& picture,
                                   const ElementGeometry& geometry, const SunDirection& sun) {
  ColourStatistics look;
  look.places = static_cast<int>(places.size());
  look_at_sun(look, picture, geometry, sun);
  if (look.places < kFewestPlaces) return look;
  std::vector<float> colours;
  colours.reserve(places.size());
  for (const Place& p : places) colours.push_back(p.colour);
  look.bluest = static_cast<double>(quantile_in_place(colours, 0.1));
  look.colour_span = static_cast<double>(quantile_in_place(colours, 0.9)) - look.bluest;
  return look;
}

}  // namespace

void look_at_sun(ColourStatistics& look, const SkyPicture& picture, const ElementGeometry& geometry,
                 const SunDirection& sun) {
  // The disc with its glare, and the sky just outside.
  constexpr Radians kCore = from_degrees(1.5), kRingBegins = from_degrees(6.0), kRingEnds = from_degrees(9.0);
  constexpr double kBright = 0.9, kDuller = 0.1;  // encoded, of the darkest channel
  const auto cosine = [](Radians angle) { return static_cast<float>(std::cos(angle.value)); };
  const float core_from = cosine(kCore), ring_from = cosine(kRingEnds), ring_to = cosine(kRingBegins);
  const glm::vec3 towards_sun(sun);
  double core = 0.0, ring = 0.0, brightest = 0.0;  // the disc alone may be smaller than the core
  int in_core = 0, in_ring = 0;
  for (int y = 0; y < picture.encoded.height(); ++y)
    for (int x = 0; x < picture.encoded.width(); ++x) {
      const float at = glm::dot(geometry.direction.at(x, y), towards_sun);
      if (at < ring_from || geometry.open.at(x, y) == 0) continue;
      const glm::vec3& e = picture.encoded.at(x, y);
      const auto level = static_cast<double>(std::min({e.r, e.g, e.b}));
      if (at > core_from) core += level, brightest = std::max(brightest, level), ++in_core;
      if (at < ring_to) ring += level, ++in_ring;
    }
  if (in_core == 0 || in_ring == 0) return;
  core /= in_core;
  ring /= in_ring;
  look.sun_seen = core > kBright && ring < core - kDuller;
  look.sun_hidden = brightest <= kBright;
}

ColourStatistics look_of(const SkyPicture& picture, const ElementGeometry& geometry, const ElementLight& light,
                         const SunDirection& sun) {
  const std::vector<Place> places = sky_places(cells_of(geometry, light));
  ColourStatistics look = colours_of_places(places, picture, geometry, sun);
  if (look.places >= kFewestPlaces) compare_with_form(look, places, sun);
  return look;
}

ColourStatistics colours_of(const SkyPicture& picture, const ElementGeometry& geometry, const ElementLight& light,
                            const SunDirection& sun) {
  return colours_of_places(sky_places(cells_of(geometry, light)), picture, geometry, sun);
}

}  // namespace kasumi
