#include "pipeline/kiosk/loop/latency.hpp"

#include <algorithm>
#include <cmath>

namespace kasumi {

namespace {

constexpr double kFirstBin_ms = 0.1;
const double kBinsPerE = 1.0 / std::log(1.01);
constexpr std::size_t kMostPending = 64;  // pictures whose flip never came

}  // namespace

void LatencyHistogram::add(Duration latency) {
  if (latency < Duration::zero()) {
    ++negative_;
    return;
  }
  const double ms = 1e3 * to_seconds(latency);
  const double bin = ms < kFirstBin_ms ? 0.0 : 1.0 + kBinsPerE * std::log(ms / kFirstBin_ms);
  ++bins_[static_cast<std::size_t>(std::min(bin, kBins - 1.0))];
  ++count_;
  max_ms_ = std::max(max_ms_, ms);
}

double LatencyHistogram::quantile_ms(double share) const {
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
  std::uint64_t counted = 0;
  for (std::size_t bin = 0; bin + 1 < kBins; ++bin) {
    counted += bins_[bin];
    if (counted >= wanted)
      return std::min(max_ms_, kFirstBin_ms * std::exp((static_cast<double>(bin) - 0.5) / kBinsPerE));
  }
  return max_ms_;
}

std::optional<LatencySummary> LatencyHistogram::summary() const {
  if (count_ + negative_ == 0) return std::nullopt;
  return LatencySummary{quantile_ms(0.5), quantile_ms(0.95), max_ms_, count_, negative_};
}

void LatencyWatch::shown(std::uint64_t picture, Instant captured_at) {
  pending_.push_back({picture, captured_at});
  if (pending_.size() > kMostPending) pending_.pop_front();
}

void LatencyWatch::flipped(std::uint64_t picture, Instant at) {
  while (!pending_.empty() && pending_.front().picture <= picture) {
    if (pending_.front().picture == picture) {
      minute_.add(at - pending_.front().captured_at);
      whole_.add(at - pending_.front().captured_at);
    }
    pending_.pop_front();
  }
}

std::optional<LatencySummary> LatencyWatch::take_minute() {
  const auto summary = minute_.summary();
  minute_ = {};
  return summary;
}

}  // namespace kasumi
