#include "pipeline/lab/prove/proof_summary.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "base/statistics.hpp"

namespace kasumi {
namespace {

template <class Which>
ErrorSummary errors_of(const Proof& proof, ProofWay way, Which which) {
  std::vector<double> errors;
  for (const auto& picture : proof.pictures)
    if (which(picture)) errors.push_back(picture.error_255(way));
  if (errors.empty()) return {};
  const double mean = std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
  return {errors.size(), median(errors), quantile(errors, 0.95), mean};
}

template <class Which>
std::array<ErrorSummary, kProofWays.size()> all_ways(const Proof& proof, Which which) {
  std::array<ErrorSummary, kProofWays.size()> ways;
  for (std::size_t k = 0; k < ways.size(); ++k) ways[k] = errors_of(proof, kProofWays[k], which);
  return ways;
}

}  // namespace

ProofSummary summary_of(const Proof& proof) {
  ProofSummary summary;
  const auto judged = [](const ProofEntry& picture) { return picture.judged(); };
  summary.ways = all_ways(proof, judged);
  summary.with_left_out = errors_of(proof, ProofWay::told, [](const auto& picture) { return picture.drawn; });
  std::array<std::vector<double>, 3> bias;
  std::vector<double> pixels;
  std::map<std::string, int> classes, reasons;
  double within = 0.0, values = 0.0;
  for (const auto& picture : proof.pictures) {
    if (!picture.left_out.empty()) ++reasons[picture.left_out.substr(0, picture.left_out.find_first_of(":("))];
    if (!picture.judged()) continue;
    ++classes[picture.air_class];
    pixels.push_back(picture.pixel_error_255);
    const auto off = picture.drawn_by(ProofWay::told) - picture.seen_255;
    for (int c = 0; c < 3; ++c) {
      bias[static_cast<std::size_t>(c)].push_back(off[c]);
      const double sigmas = std::abs(off[c]) / picture.sigma_255[c];
      within += sigmas <= 1.0;
      values += 1.0;
      summary.worst_sigma = std::max(summary.worst_sigma, sigmas);
    }
  }
  for (int c = 0; c < 3; ++c) summary.bias_255[c] = median(bias[static_cast<std::size_t>(c)]);
  summary.within_sigma_share = values > 0.0 ? within / values : 0.0;
  summary.pixel_median_255 = median(pixels);
  for (const auto& [name, count] : classes)
    summary.classes.push_back(
        {name, all_ways(proof, [&](const auto& picture) { return picture.judged() && picture.air_class == name; })});
  std::ranges::stable_sort(summary.classes, std::greater{}, [](const auto& one) { return one.ways[0].pictures; });
  summary.left_out.assign(reasons.begin(), reasons.end());
  return summary;
}

}  // namespace kasumi
