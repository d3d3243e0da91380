#include "calib/mask/rim_candidates.hpp"

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <utility>

#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

#include "base/units.hpp"

namespace kasumi {
namespace {

constexpr double kSmallest = 0.15, kLargest = 1.1;  // radius over the frame's shorter and longer side
constexpr int kCell_px = 4;
constexpr double kBeyond = 0.25;  // centres may lie that far outside the frame, of its longer side
constexpr std::size_t kCentres = 10, kRadiiOfCentre = 4;
constexpr int kSectors = 90;

double shorter(cv::Size frame) {
  return std::min(frame.width, frame.height);
}
double longer(cv::Size frame) {
  return std::max(frame.width, frame.height);
}

std::vector<glm::dvec2> centres_by_votes(const std::vector<RimEdge>& edges, cv::Size frame) {
  const int margin = static_cast<int>(kBeyond * longer(frame)) / kCell_px;
  cv::Mat1f votes(frame.height / kCell_px + 1 + 2 * margin, frame.width / kCell_px + 1 + 2 * margin, 0.0f);
  const float from = static_cast<float>(kSmallest * shorter(frame)) / kCell_px,
              to = static_cast<float>(kLargest * longer(frame)) / kCell_px;
  for (const RimEdge& edge : edges) {
    const glm::vec2 start = edge.point / static_cast<float>(kCell_px) + glm::vec2{static_cast<float>(margin) + 0.5f};
    for (const float side : {-1.0f, 1.0f})
      for (float r = from; r < to; r += 1.0f) {
        const glm::vec2 at = start + side * r * edge.normal;
        if (at.x < 0.0f || at.y < 0.0f || at.x >= static_cast<float>(votes.cols) ||
            at.y >= static_cast<float>(votes.rows))
          break;
        votes(static_cast<int>(at.y), static_cast<int>(at.x)) += edge.strength;
      }
  }
  // What edges of no common centre add up to is smooth.
  cv::Mat1f sharp, smooth;
  cv::GaussianBlur(votes, sharp, {}, 1.3, 0.0, cv::BORDER_CONSTANT);
  cv::GaussianBlur(votes, smooth, {}, 6.0, 0.0, cv::BORDER_CONSTANT);
  votes = sharp - smooth;
  std::vector<glm::dvec2> centres;
  while (centres.size() < kCentres) {
    double most = 0.0;
    cv::Point at;
    cv::minMaxLoc(votes, nullptr, &most, nullptr, &at);
    if (most <= 0.0) break;
    centres.push_back(static_cast<double>(kCell_px) * glm::dvec2{at.x - margin, at.y - margin});
    cv::circle(votes, at, 3, cv::Scalar(0.0), cv::FILLED);
  }
  return centres;
}

// Share of the turn, at each radius, that has an edge across the radius there; of what the frame shows.
std::vector<double> coverage_by_radius(const std::vector<RimEdge>& edges, const glm::dvec2& centre, cv::Size frame) {
  const auto radii = static_cast<std::size_t>(kLargest * longer(frame) / 2.0);
  std::vector<std::bitset<kSectors>> covered(radii + 2);
  for (const RimEdge& edge : edges) {
    const glm::dvec2 from = glm::dvec2{edge.point} - centre;
    const double distance = glm::length(from);
    const auto bin = static_cast<std::size_t>(distance / 2.0);
    if (bin >= radii || distance < kSmallest * shorter(frame)) continue;
    if (std::abs(glm::dot(glm::dvec2{edge.normal}, from)) < 0.93 * distance) continue;
    const double turn = std::atan2(from.y, from.x) / (2.0 * kPi) + 0.5;
    covered[bin].set(static_cast<std::size_t>(std::min(kSectors - 1, static_cast<int>(turn * kSectors))));
  }
  std::array<glm::dvec2, kSectors> directions;
  for (int i = 0; i < kSectors; ++i) {
    const double turn = (i + 0.5) * 2.0 * kPi / kSectors - kPi;
    directions[static_cast<std::size_t>(i)] = {std::cos(turn), std::sin(turn)};
  }
  std::vector<double> coverage(radii, 0.0);
  for (std::size_t bin = 1; bin + 1 < radii; ++bin) {
    const auto on = (covered[bin - 1] | covered[bin] | covered[bin + 1]).count();
    if (on < 8) continue;
    int shown = 0;
    for (const glm::dvec2& direction : directions) {
      const auto at = centre + (2.0 * static_cast<double>(bin) + 1.0) * direction;
      shown += at.x > 1.0 && at.y > 1.0 && at.x < frame.width - 2.0 && at.y < frame.height - 2.0;
    }
    coverage[bin] = static_cast<double>(on) / std::max(shown, 12) * std::sqrt(static_cast<double>(on) / kSectors);
  }
  return coverage;
}

}  // namespace

std::vector<Rim> rims_by_votes(const std::vector<RimEdge>& edges, cv::Size frame) {
  std::vector<std::pair<double, Rim>> rims;
  auto centres = centres_by_votes(edges, frame);
  centres.push_back({0.5 * (frame.width - 1), 0.5 * (frame.height - 1)});  // where most lenses are
  for (const glm::dvec2& centre : centres) {
    auto coverage = coverage_by_radius(edges, centre, frame);
    for (std::size_t i = 0; i < kRadiiOfCentre; ++i) {
      const auto most = std::ranges::max_element(coverage);
      if (most == coverage.end() || *most < 0.08) break;
      const auto bin = most - coverage.begin();
      rims.push_back({*most, Rim{centre, 2.0 * static_cast<double>(bin) + 1.0}});
      const auto reach = std::max<std::ptrdiff_t>(3, bin / 30);
      std::fill(coverage.begin() + std::max<std::ptrdiff_t>(0, bin - reach),
                coverage.begin() + std::min<std::ptrdiff_t>(std::ssize(coverage), bin + reach + 1), 0.0);
    }
  }
  std::ranges::stable_sort(rims, std::ranges::greater{}, &std::pair<double, Rim>::first);
  std::vector<Rim> sorted;
  for (const auto& [coverage, rim] : rims) sorted.push_back(rim);
  return sorted;
}

std::vector<Rim> rims_by_surround(const cv::Mat1b& surround) {
  const cv::Size frame = surround.size();
  std::vector<glm::dvec2> border;
  for (int y = 2; y + 2 < surround.rows; ++y)
    for (int x = 2; x + 2 < surround.cols; ++x)
      if (surround(y, x) && (!surround(y, x - 1) || !surround(y, x + 1) || !surround(y - 1, x) || !surround(y + 1, x)))
        border.emplace_back(x, y);
  std::mt19937 random(1);
  std::ranges::shuffle(border, random);
  constexpr std::size_t kMostPoints = 600;
  if (border.size() > kMostPoints) border.resize(kMostPoints);
  if (border.size() < 30) return {};
  constexpr int kTrials = 400;
  std::vector<Rim> rims;
  for (int i = 0; i < 2 && border.size() >= 30; ++i) {
    std::optional<Rim> best;
    double most = 0.04 * static_cast<double>(kMostPoints);
    const auto inliers = [&](const Rim& rim) {
      const double tolerance = std::max(1.5, 0.008 * rim.radius);
      return static_cast<double>(
          std::ranges::count_if(border, [&](const auto& p) { return std::abs(rim.off(p)) < tolerance; }));
    };
    for (int trial = 0; trial < kTrials; ++trial) {
      const auto &a = border[random() % border.size()], &b = border[random() % border.size()],
                 &c = border[random() % border.size()];
      const auto ab = b - a, ac = c - a;
      const double twice_area = ab.x * ac.y - ab.y * ac.x;
      if (std::abs(twice_area) < 100.0) continue;
      const glm::dvec2 to_centre = glm::dvec2{ac.y * glm::dot(ab, ab) - ab.y * glm::dot(ac, ac),
                                              ab.x * glm::dot(ac, ac) - ac.x * glm::dot(ab, ab)} /
                                   (2.0 * twice_area);
      const Rim rim{a + to_centre, glm::length(to_centre)};
      if (rim.radius < kSmallest * shorter(frame) || rim.radius > kLargest * longer(frame)) continue;
      const double beyond = kBeyond * longer(frame);
      if (rim.centre.x < -beyond || rim.centre.y < -beyond || rim.centre.x > frame.width + beyond ||
          rim.centre.y > frame.height + beyond)
        continue;
      if (const double on = inliers(rim); on > most) {
        most = on;
        best = rim;
      }
    }
    if (!best) break;
    rims.push_back(*best);
    std::erase_if(border, [&](const auto& p) { return std::abs(best->off(p)) < 0.03 * best->radius; });
  }
  return rims;
}

}  // namespace kasumi
