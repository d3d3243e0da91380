#include "calib/mask/rim_evidence.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

#include "base/statistics.hpp"
#include "base/units.hpp"

namespace kasumi {
namespace {

constexpr int kTurns = kRimSectors;

bool shows(cv::Size frame, const glm::dvec2& point, double margin) {
  return point.x >= margin && point.y >= margin && point.x <= frame.width - 1 - margin &&
         point.y <= frame.height - 1 - margin;
}

cv::Vec3f tone_at(const cv::Mat3f& tones, const glm::dvec2& point) {
  return tones(std::clamp(static_cast<int>(point.y + 0.5), 0, tones.rows - 1),
               std::clamp(static_cast<int>(point.x + 0.5), 0, tones.cols - 1));
}

// Mean tones between two shares of the radius; of what the frame shows.
cv::Vec3f band(const cv::Mat3f& tones, const Rim& rim, const glm::dvec2& ahead, double from, double to) {
  cv::Vec3f sum;
  float count = 0.0f;
  for (int k = 0; k < 4; ++k) {
    const auto at = rim.point_at(ahead, from + (to - from) * k / 3.0);
    if (!shows(tones.size(), at, 0.0)) continue;
    sum += tone_at(tones, at);
    count += 1.0f;
  }
  return sum * (1.0f / std::max(1.0f, count));
}

float distance(const cv::Vec3f& a, const cv::Vec3f& b) {
  return static_cast<float>(cv::norm(a - b) / std::sqrt(3.0));
}
float light(const cv::Vec3f& tone) {
  return (tone[0] + tone[1] + tone[2]) / 3.0f;
}

cv::Vec3f middle_of(const std::vector<cv::Vec3f>& tones) {
  std::array<std::vector<float>, 3> channels;
  for (const auto& tone : tones)
    for (std::size_t c = 0; c < 3; ++c) channels[c].push_back(tone[static_cast<int>(c)]);
  return {median_in_place(channels[0]), median_in_place(channels[1]), median_in_place(channels[2])};
}

float scatter(const std::vector<cv::Vec3f>& tones) {
  const cv::Vec3f middle = middle_of(tones);
  std::vector<float> away;
  for (const auto& tone : tones) away.push_back(distance(tone, middle));
  return median_in_place(away);
}

void add_steps(RimEvidence& evidence, const Rim& rim, const cv::Mat3f& tones) {
  std::vector<cv::Vec3f> inside, outside;
  std::vector<float> steps, ripples, depths;
  double sign = 0.0, shown = 0.0;
  const double gap = std::max(0.012, 2.5 / rim.radius), wide = std::max(0.05, 6.0 / rim.radius);
  for (int i = 0; i < kTurns; ++i) {
    const double turn = 2.0 * kPi * (i + 0.5) / kTurns;
    const glm::dvec2 ahead{std::cos(turn), std::sin(turn)};
    if (!shows(tones.size(), rim.point_at(ahead), 1.0)) continue;
    shown += 1.0;
    if (!shows(tones.size(), rim.point_at(ahead, 1.0 + gap), 0.5)) continue;
    const auto in = band(tones, rim, ahead, 1.0 - wide, 1.0 - gap),
               out = band(tones, rim, ahead, 1.0 + gap, 1.0 + wide);
    inside.push_back(in);
    outside.push_back(out);
    steps.push_back(distance(in, out));
    depths.push_back(distance(band(tones, rim, ahead, 0.6, 0.9), out));
    sign += light(in) > light(out) ? 1.0 : -1.0;
    ripples.push_back(distance(band(tones, rim, ahead, 1.0 + gap, 1.0 + 0.5 * (gap + wide)),
                               band(tones, rim, ahead, 1.0 + 0.5 * (gap + wide), 1.0 + 2.0 * wide)));
  }
  evidence.shown = shown / kTurns;
  if (steps.empty()) return;
  evidence.same_way = std::abs(sign) / static_cast<double>(steps.size());
  evidence.step = static_cast<double>(median(steps));
  evidence.weak_step = static_cast<double>(quantile(steps, 0.25));
  const double over = evidence.step + 2.0;
  evidence.uneven = static_cast<double>(scatter(outside)) / over;
  evidence.uneven_inside = static_cast<double>(scatter(inside)) / over;
  evidence.depth = std::min(2.0, evidence.step / (static_cast<double>(median_in_place(depths)) + 2.0));
  evidence.ripple = static_cast<double>(median_in_place(ripples)) / over;
}

void add_edges(RimEvidence& evidence, const Rim& rim, const std::vector<RimEdge>& edges) {
  const double tolerance = std::max(1.2, 0.007 * rim.radius);
  std::array<bool, static_cast<std::size_t>(kTurns)> on{}, tight{}, further{};
  for (const RimEdge& edge : edges_along(edges, rim, 0.4 * rim.radius)) {
    const double off = rim.off(edge.point);
    const auto sector = static_cast<std::size_t>(sector_of(rim, edge.point));
    if (std::abs(off) <= tolerance) on[sector] = true;
    if (std::abs(off) <= 0.5 * tolerance) tight[sector] = true;
    if (off > 3.0 * tolerance) further[sector] = true;
  }
  const auto share = [&](const auto& sectors) {
    return static_cast<double>(std::ranges::count(sectors, true)) / kTurns;
  };
  const double shown = std::max(0.05, evidence.shown);
  evidence.covered = std::min(1.0, share(on) / shown);
  evidence.tightly = std::min(1.0, share(tight) / shown);
  evidence.beyond = std::min(1.0, share(further) / shown);
}

// What is as unlike the surround as most of the picture inside is counts as lit; flare and faint rings do not.
constexpr float kLitShare = 0.3f;

void add_areas(RimEvidence& evidence, const Rim& rim, const cv::Mat3f& tones) {
  const double gap = std::max(2.0, 0.02 * rim.radius);
  std::vector<cv::Vec3f> in, out;
  for (int y = 2; y < tones.rows; y += 5)
    for (int x = 2; x < tones.cols; x += 5) {
      const double off = rim.off({x, y});
      if (std::abs(off) > gap) (off > 0.0 ? out : in).push_back(tones(y, x));
    }
  if (in.empty() || out.empty()) return;
  const cv::Vec3f surround = middle_of(out);
  std::vector<float> unlike;
  for (const auto& tone : in) unlike.push_back(distance(tone, surround));
  const float lit = kLitShare * median(unlike) + 1.0f;
  const auto is_lit = [&](const cv::Vec3f& tone) { return distance(tone, surround) > lit; };
  evidence.lit_inside = static_cast<double>(std::ranges::count_if(unlike, [&](float u) { return u > lit; })) /
                        static_cast<double>(in.size());
  evidence.lit_outside = static_cast<double>(std::ranges::count_if(out, is_lit)) / static_cast<double>(out.size());
  double lit_in = 0.0, lit_out = 0.0, shown = 0.0;
  for (int i = 0; i < kTurns; ++i) {
    const double turn = 2.0 * kPi * (i + 0.5) / kTurns;
    const glm::dvec2 ahead{std::cos(turn), std::sin(turn)};
    for (int k = 0; k < 3; ++k) {
      const double away = std::max(2.0 + k, (0.012 + 0.012 * k) * rim.radius) / rim.radius;
      const auto outer = rim.point_at(ahead, 1.0 + away), inner = rim.point_at(ahead, 1.0 - away);
      if (!shows(tones.size(), outer, 0.0) || !shows(tones.size(), inner, 0.0)) continue;
      shown += 1.0;
      lit_out += is_lit(tone_at(tones, outer)) ? 1.0 : 0.0;
      lit_in += is_lit(tone_at(tones, inner)) ? 1.0 : 0.0;
    }
  }
  evidence.hem_out = lit_out / std::max(1.0, shown);
  evidence.hem_in = lit_in / std::max(1.0, shown);
}

}  // namespace

void compare(std::vector<RimEvidence*> all) {
  constexpr double kDark = 1.5;  // tones, below which steps are noise
  double largest = 0.0;
  for (const RimEvidence* one : all)
    if (one->covered > 0.7 && one->tightly > 0.55 && one->shown > 0.25) largest = std::max(largest, one->step);
  for (RimEvidence* one : all)
    one->relative_step = std::log((one->step + kDark) / (std::max(largest, one->step) + kDark));
}

RimEvidence evidence_for(const Rim& rim, const cv::Mat3f& tones, const std::vector<RimEdge>& edges) {
  RimEvidence evidence;
  add_steps(evidence, rim, tones);
  add_edges(evidence, rim, edges);
  add_areas(evidence, rim, tones);
  const glm::dvec2 middle{0.5 * (tones.cols - 1) * rim.aspect, 0.5 * (tones.rows - 1)};
  const double shorter = std::min(tones.cols * rim.aspect, static_cast<double>(tones.rows));
  evidence.off_centre = glm::distance(rim.centre, middle) / shorter;
  evidence.size = rim.radius / shorter;
  evidence.sigma = rim.sigma / rim.radius;
  return evidence;
}

// Weights by logistic regression on drawn pictures (tests/calib/mask/strange_rims) and a few of real cameras.
double score_of(const RimEvidence& e) {
  const auto saturated = [](double value, double half) { return value / (value + half); };
  // A ring much fainter than another is light scattered in the lens.
  const double faint = std::min(0.0, e.relative_step + 1.0);
  return -4.90 + 2.66 * e.covered + 3.15 * e.tightly + 2.42 * e.covered * std::min(1.0, e.shown / 0.5) +
         0.40 * e.shown - 0.92 * e.beyond - 0.31 * saturated(e.step, 8.0) + 2.61 * saturated(e.weak_step, 5.0) +
         0.70 * e.same_way - 1.80 * std::min(1.5, e.uneven) - 1.56 * std::min(1.5, e.uneven_inside) -
         0.71 * std::min(1.5, e.ripple) - 1.13 * e.lit_outside - 1.50 * e.lit_inside -
         1.81 * std::min(1.0, e.off_centre) - 2.43 * std::abs(std::log(e.size / 0.5)) - 0.31 * e.depth -
         4.29 * std::min(1.0, 50.0 * e.sigma) + 0.23 * e.relative_step + 1.57 * faint +
         1.52 * std::min(1.0, e.tightly / (e.covered + 0.1)) - 1.72 * e.hem_out - 0.95 * e.hem_in;
}

}  // namespace kasumi
