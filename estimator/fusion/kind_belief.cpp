#include "estimator/fusion/kind_belief.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kasumi {
namespace {

// Chosen: longer, a new kind shows late; shorter, single pictures change sky and light.
constexpr Duration kAveragedOver = std::chrono::minutes(20);
// The time in which the exponent returns to its usual value, which goes with the kind.
constexpr Duration kKindMemory = std::chrono::hours(24);
// Chosen: a high sky shows the kind better than a low one, so the low one waits for a gap of that length.
constexpr Duration kSkyGoesBefore = std::chrono::hours(2);
constexpr double kClearlyLikelier = 1.5;  // times as likely
// Hysteresis: shares near one half do not switch the sky's model back and forth.
constexpr double kToPapers = 0.6, kFromPapers = 0.4;

double passed_over(Instant from, Instant to, Duration span) {
  return std::max(0.0, to_seconds(to - from) / to_seconds(span));
}

std::size_t likeliest(const KindBelief::Kinds& kinds) {
  return static_cast<std::size_t>(std::ranges::max_element(kinds) - kinds.begin());
}

}  // namespace

KindBelief::Kinds KindBelief::kinds(Instant when) const {
  Kinds now{};
  if (given_) {
    now[static_cast<std::size_t>(*given_)] = 1.0;
    return now;
  }
  const double kept = seen_ ? std::exp(-passed_over(*seen_, when, kKindMemory)) : 0.0;
  for (std::size_t i = 0; i < now.size(); ++i)
    now[i] = kept * kinds_[i] + (1.0 - kept) / static_cast<double>(now.size());
  return now;
}

AerosolKind KindBelief::shown() const {
  return given_.value_or(shown_);
}

KindBelief::Beside KindBelief::beside() const {
  if (given_ || !seen_) return {};
  const auto known = [&](AerosolKind kind) {
    return std::max(0.0, kinds_[static_cast<std::size_t>(kind)] - 1.0 / static_cast<double>(kinds_.size()));
  };
  Beside beside;
  double most = 0.0;
  for (const AerosolKind kind : kAerosolKinds)
    if (kind != shown_ && known(kind) > most) most = known(kind), beside.kind = kind;
  if (most > 0.0) beside.share = most / (most + known(shown_));
  return beside;
}

void KindBelief::observe(const FoundAerosol& found, bool by_sky, Instant when) {
  if (!by_sky && seen_above_ && when - *seen_above_ < kSkyGoesBefore) return;
  const double total = std::accumulate(found.kinds.begin(), found.kinds.end(), 0.0);
  const bool first = !seen_ || (by_sky && !seen_above_);
  if (by_sky) seen_above_ = when;
  // At first as the picture says; then by the time that has passed, however many pictures there were.
  const double weight = first ? 1.0 : 1.0 - std::exp(-std::max(1e-3, passed_over(*seen_, when, kAveragedOver)));
  papers_share_ += weight * (std::clamp(found.papers_share, 0.0, 1.0) - papers_share_);
  if (papers_share_ > kToPapers || (first && papers_share_ > 0.5)) papers_sky_ = true;
  if (papers_share_ < kFromPapers || (first && papers_share_ <= 0.5)) papers_sky_ = false;

  Kinds now = kinds(when);
  seen_ = seen_ ? std::max(*seen_, when) : when;
  if (total > 0.0)
    for (std::size_t i = 0; i < now.size(); ++i) now[i] += weight * (found.kinds[i] / total - now[i]);
  kinds_ = now;
  const auto best = likeliest(kinds_);
  const double held = kinds_[static_cast<std::size_t>(shown_)];
  if (first && total > 0.0) shown_ = kAerosolKinds[best];
  if (kinds_[best] > kClearlyLikelier * held) shown_ = kAerosolKinds[best];
}

void KindBelief::remember(AerosolKind kind, bool papers_sky, Instant when) {
  shown_ = kind;
  papers_sky_ = papers_sky;
  papers_share_ = papers_sky ? 1.0 : 0.0;
  // Remembered is that it was the likeliest, not by how much.
  kinds_.fill(0.5 / static_cast<double>(kinds_.size() - 1));
  kinds_[static_cast<std::size_t>(kind)] = 0.5;
  seen_ = seen_above_ = when;
}

}  // namespace kasumi
