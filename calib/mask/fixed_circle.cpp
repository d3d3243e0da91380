#include "calib/mask/fixed_circle.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include <glm/geometric.hpp>

namespace kasumi {
namespace {

constexpr double kAgree = 0.02;        // of the radius
constexpr double kNear = 0.08;         // circles this near are one rim seen badly, where few pictures see them
constexpr double kFew = 0.34;          // of those that see the circle they are near
constexpr double kOther = 0.25;        // weight of a vote for another circle than a picture's best
constexpr double kCounts = 0.1;        // least confidence of a circle that is counted
constexpr double kSure = 0.5;          // a picture this sure of its own circle keeps it
constexpr double kByOthersOnly = 0.3;  // of their confidence, where the picture itself shows no sign of their circle

using Pictures = std::vector<std::size_t>;

double difference(const ImageCircle& a, const ImageCircle& b) {
  return std::max(glm::distance(a.centre, b.centre), std::abs(a.radius_px - b.radius_px)) / b.radius_px;
}

// The likeliest circle of a picture that agrees with one.
std::optional<PossibleCircle> match(const FoundCircle& found, const ImageCircle& circle) {
  if (found.confidence >= kCounts && difference(found.circle, circle) < kAgree)
    return PossibleCircle{found.circle, found.confidence};
  for (const PossibleCircle& other : found.others)
    if (other.confidence >= kCounts && difference(other.circle, circle) < kAgree)
      return PossibleCircle{other.circle, kOther * other.confidence};
  return std::nullopt;
}

double weighted_median(std::vector<std::pair<double, double>> values) {
  std::ranges::sort(values);
  double all = 0.0, sum = 0.0;
  for (const auto& [value, weight] : values) all += weight;
  for (const auto& [value, weight] : values)
    if ((sum += weight) >= 0.5 * all) return value;
  return values.back().first;
}

struct Agreement {
  ImageCircle circle;
  double votes = 0.0;
  double confidence = 0.0;
  int best_of = 0;  // pictures whose best circle it is
};

Agreement agreement_on(const ImageCircle& circle, const std::vector<SizedCircle>& all, const Pictures& among) {
  Agreement agreement{circle};
  std::vector<std::pair<double, double>> x, y, r, sigma;
  for (const std::size_t i : among)
    if (const auto one = match(*all[i].found, circle)) {
      agreement.votes += one->confidence;
      agreement.confidence = std::max(agreement.confidence, one->confidence);
      agreement.best_of += difference(all[i].found->circle, circle) < kAgree ? 1 : 0;
      x.emplace_back(one->circle.centre.x, one->confidence);
      y.emplace_back(one->circle.centre.y, one->confidence);
      r.emplace_back(one->circle.radius_px, one->confidence);
      sigma.emplace_back(one->circle.sigma_px, one->confidence);
    }
  if (x.empty()) return agreement;
  // What all pictures share, of soft rims and fringes, does not average out.
  constexpr double kMostGain = 4.0;
  agreement.circle = {{weighted_median(x), weighted_median(y)},
                      weighted_median(r),
                      weighted_median(sigma) / std::sqrt(std::min(kMostGain, static_cast<double>(sigma.size())))};
  return agreement;
}

// Circles that are the best of at least two pictures, the one of most first.
std::vector<Agreement> agreements_of(const std::vector<SizedCircle>& all, const Pictures& among) {
  constexpr std::size_t kMostAsked = 60;  // of many pictures a few name every circle there is
  std::vector<Agreement> found;
  const std::size_t step = std::max<std::size_t>(1, among.size() / kMostAsked);
  for (std::size_t k = 0; k < among.size(); k += step) {
    auto agreement = agreement_on(all[among[k]].found->circle, all, among);
    agreement = agreement_on(agreement.circle, all, among);
    if (agreement.best_of >= 2) found.push_back(agreement);
  }
  std::ranges::stable_sort(found, std::ranges::greater{}, [](const Agreement& one) {
    return std::pair{one.best_of, one.votes};
  });
  std::vector<Agreement> apart;
  for (const Agreement& one : found)
    if (std::ranges::none_of(apart, [&](const Agreement& larger) {
          return difference(one.circle, larger.circle) < (one.best_of < kFew * larger.best_of ? kNear : kAgree);
        }))
      apart.push_back(one);
  return apart;
}

const Agreement* agreement_for(const FoundCircle& found, const std::vector<Agreement>& agreements) {
  for (const Agreement& one : agreements)
    if (difference(found.circle, one.circle) < kAgree) return &one;
  for (const Agreement& one : agreements)
    if ((found.confidence < kSure || difference(found.circle, one.circle) < kNear) && match(found, one.circle))
      return &one;
  return nullptr;
}

// Pictures of one size and shape of pixels.
void settle(const std::vector<SizedCircle>& all, const Pictures& with, const Pictures& without,
            std::vector<std::optional<FoundCircle>>& circles) {
  const auto agreements = agreements_of(all, with);
  Pictures open = without;
  for (const std::size_t i : with)
    if (const Agreement* agreement = agreement_for(*all[i].found, agreements)) {
      circles[i]->circle = agreement->circle;
      circles[i]->confidence = agreement->confidence;
    } else if (circles[i]->confidence < kSure) {
      open.push_back(i);
    }
  if (agreements.size() != 1) return;
  const auto& [circle, votes, confidence, best_of] = agreements.front();
  for (const std::size_t i : open)
    circles[i] = FoundCircle{circle, kByOthersOnly * confidence, {}, all[with.front()].found->pixel_aspect, {}};
}

}  // namespace

std::vector<std::optional<FoundCircle>> circles_of_fixed_cameras(const std::vector<SizedCircle>& pictures) {
  std::vector<std::optional<FoundCircle>> circles;
  std::map<std::pair<int, int>, std::pair<Pictures, Pictures>> by_size;  // with and without a circle
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    circles.push_back(pictures[i].found);
    auto& [with, without] = by_size[{pictures[i].width, pictures[i].height}];
    (pictures[i].found ? with : without).push_back(i);
  }
  for (const auto& [size, group] : by_size) {
    // A squeezed rim is not compared with round ones.
    std::map<int, Pictures> by_aspect;
    for (const std::size_t i : group.first)
      by_aspect[static_cast<int>(std::lround(50.0 * pictures[i].found->pixel_aspect))].push_back(i);
    for (const auto& [aspect, with] : by_aspect)
      settle(pictures, with, by_aspect.size() == 1 ? group.second : Pictures{}, circles);
  }
  return circles;
}

}  // namespace kasumi
