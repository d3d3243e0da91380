#include "estimator/passers/passers.hpp"

#include <algorithm>
#include <vector>

namespace kasumi {
namespace {

constexpr float kSeed = 6.5F, kGrow = 3.5F;  // of a cell's own standard deviations
constexpr float kNearSeed = 4.5F;            // where a passer was in the picture before
constexpr float kAlone = 14.0F;              // a single cell counts: a bird
constexpr int kLeastCells = 3;               // else
constexpr double kDark_luma = 18.0;          // median of the part
constexpr float kStill_s = 30.0F;            // no person keeps as still
constexpr float kStillShare = 0.9F;          // of an island's cells: the edge of a parked car flickers
// More at once is new light or a turned camera (docs/cameras.md), or a vehicle that large.
constexpr double kUnsettledShare = 0.15;
// Chosen: longer than a passer takes, so that only new light has the scene learnt anew.
constexpr Duration kUnsettled = std::chrono::minutes(2);
constexpr Duration kOutdated = std::chrono::minutes(20);  // without a picture that was bright enough

bool near_any(const Image<std::uint8_t>& mask, int column, int row) {
  for (int y = std::max(0, row - 2); y <= std::min(mask.height() - 1, row + 2); ++y)
    for (int x = std::max(0, column - 2); x <= std::min(mask.width() - 1, column + 2); ++x)
      if (mask.at(x, y)) return true;
  return false;
}

}  // namespace

std::string_view name_of(PassersState state) {
  switch (state) {
    case PassersState::watching: return "watching";
    case PassersState::learning: return "learning";
    case PassersState::dark: return "dark";
    case PassersState::unsettled: return "unsettled";
  }
  return "";
}

std::string_view reason_of(PassersState state) {
  switch (state) {
    case PassersState::watching: return "";
    case PassersState::learning: return "the scene without people is not known yet: the building covers them";
    case PassersState::dark: return "too dark to detect people before the building: it covers them";
    case PassersState::unsettled:
      return "more of the picture has changed than people cover, by new light or a turned camera: the building covers "
             "them";
  }
  return "";
}

void Passers::forget() {
  expected_ = ExpectedScene(place_, tone_);
  std::ranges::fill(covered_.elements(), std::uint8_t{0});
  unsettled_since_.reset();
}

// Cells that differ much, with those around that differ a little.
void Passers::find_covered(const Image<float>& score) {
  const Image<std::uint8_t> before = covered_;
  Image<std::uint8_t> seen(covered_.width(), covered_.height(), 0);
  std::ranges::fill(covered_.elements(), std::uint8_t{0});
  std::vector<glm::ivec2> island;
  for (int row = 0; row < score.height(); ++row)
    for (int column = 0; column < score.width(); ++column) {
      if (seen.at(column, row) || score.at(column, row) < kNearSeed) continue;
      if (score.at(column, row) < kSeed && !near_any(before, column, row)) continue;
      island.assign(1, {column, row});
      seen.at(column, row) = 1;
      bool was_there = near_any(before, column, row);
      float greatest = 0.0F;
      for (std::size_t i = 0; i < island.size(); ++i) {
        const auto at = island[i];
        greatest = std::max(greatest, score.at(at.x, at.y));
        was_there = was_there || before.at(at.x, at.y);
        for (int d = 0; d < 9; ++d) {
          const int x = at.x + d % 3 - 1, y = at.y + d / 3 - 1;
          if (!score.contains(x, y) || seen.at(x, y) || score.at(x, y) < kGrow) continue;
          seen.at(x, y) = 1;
          island.push_back({x, y});
        }
      }
      if (static_cast<int>(island.size()) < kLeastCells && greatest < kAlone && !was_there) continue;
      const auto still =
          std::ranges::count_if(island, [&](const glm::ivec2& at) { return expected_.still_s(at.x, at.y) > kStill_s; });
      if (static_cast<float>(still) > kStillShare * static_cast<float>(island.size())) continue;
      for (const auto& at : island) covered_.at(at.x, at.y) = 1;
    }
}

const PassersLook& Passers::look(const PictureView& picture, Instant captured_at) {
  const Duration since = before_ ? std::max(Duration::zero(), captured_at - *before_) : Duration::zero();
  before_ = captured_at;
  last_ = {};
  if (place_.empty() || place_.left + place_.width > picture.width || place_.top + place_.height > picture.height)
    return last_;
  if (seen_ && captured_at - *seen_ > kOutdated) forget();
  part_.read(picture, place_);
  const auto& score = expected_.compare(part_, since);
  last_.known_share = expected_.known_share();
  if (expected_.median_luma() < kDark_luma) {
    last_.state = PassersState::dark;
    std::ranges::fill(covered_.elements(), std::uint8_t{0});
    return last_;
  }
  seen_ = captured_at;
  if (!expected_.known()) {
    last_.until_watching = expected_.until_known();
    expected_.learn(part_, covered_, captured_at, since, false);
    return last_;
  }
  find_covered(score);
  const auto cells = static_cast<double>(covered_.elements().size());
  last_.covered_share = static_cast<double>(std::ranges::count(covered_.elements(), 1)) / cells;
  const bool settled = last_.covered_share <= kUnsettledShare;
  if (settled) {
    unsettled_since_.reset();
    last_.state = PassersState::watching;
    expected_.expect_pixels(covered_);
    last_.in_front = outline_of(part_, expected_, covered_);
  } else {
    last_.state = PassersState::unsettled;
    if (!unsettled_since_) unsettled_since_ = captured_at;
    if (captured_at - *unsettled_since_ > kUnsettled) {
      forget();
      return last_;
    }
    std::ranges::fill(covered_.elements(), std::uint8_t{0});
  }
  expected_.learn(part_, covered_, captured_at, since, settled);
  return last_;
}

}  // namespace kasumi
