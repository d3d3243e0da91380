#include "pipeline/lab/photographs/estimate_tally.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace kasumi {

std::string why_useless(const TurbidityEstimate& estimate) {
  const bool named = estimate.sky != SkyCondition::unknown && estimate.sky != SkyCondition::clear &&
                     estimate.sky != SkyCondition::partly_cloudy;
  return named ? std::string(name_of(estimate.sky)) : estimate.reason;
}

std::string EstimateTally::told(std::string_view what) const {
  constexpr std::size_t kMostReasons = 3;
  if (useful_ > 0) return {};
  std::vector<std::pair<std::string, std::size_t>> reasons(useless_.begin(), useless_.end());
  std::ranges::stable_sort(reasons, std::ranges::greater{}, [](const auto& reason) { return reason.second; });
  std::size_t all = unread_;
  for (const auto& [why, count] : reasons) all += count;
  if (all == 0) return fmt::format("no {} was given: the list on standard input is empty", what);
  if (all == 1 && unread_ == 0)
    return fmt::format("the {} does not determine the air: {}", what, reasons.front().first);
  std::string text = fmt::format("none of {} {}s determines the air: ", all, what);
  for (std::size_t i = 0; i < std::min(reasons.size(), kMostReasons); ++i)
    text += fmt::format("{}{} x {}", i == 0 ? "" : "; ", reasons[i].second, reasons[i].first);
  if (reasons.size() > kMostReasons) text += "; ...";
  if (unread_ > 0) text += fmt::format("{}{} could not be read", reasons.empty() ? "" : "; ", unread_);
  return text;
}

}  // namespace kasumi
