#include "capture/picture_condition.hpp"

#include <algorithm>
#include <array>

#include "base/saturation.hpp"

namespace kasumi {

namespace {

constexpr int kColumns = 32, kRows = 24;  // cells
constexpr int kSamples = 4;               // each way in a cell
constexpr int kFingerprintRows = 64;
constexpr int kDark = 40;  // of 255; limited range has black at 16

// Where the channel that represents brightness lies: Y, or G of RGB.
struct Channel {
  std::size_t offset, step;
};
Channel brightness_of(PixelLayout layout) {
  switch (layout) {
    case PixelLayout::rgb8:
    case PixelLayout::bgr8: return {1, 3};
    case PixelLayout::rgba8:
    case PixelLayout::bgra8: return {1, 4};
    case PixelLayout::yuyv: return {0, 2};
    case PixelLayout::uyvy: return {1, 2};
    default: return {0, 1};
  }
}

std::size_t spread_over(int index, int count, int size) {
  return static_cast<std::size_t>((2 * index + 1) * size / (2 * count));
}

// FNV-1a, eight bytes at a time.
std::uint64_t fingerprint_of(const PictureView& picture) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto row_bytes = plane_size(picture.layout, picture.width, picture.height, 0).row_bytes;
  for (int i = 0; i < kFingerprintRows; ++i) {
    const auto& plane = picture.planes[0];
    const auto* row = plane.data + spread_over(i, kFingerprintRows, picture.height) * plane.stride;
    for (std::size_t x = 0; x < row_bytes; x += 8) {
      std::uint64_t word = 0;
      std::copy_n(row + x, std::min<std::size_t>(8, row_bytes - x), reinterpret_cast<std::uint8_t*>(&word));
      hash = (hash ^ word) * 0x100000001b3u;
      hash ^= hash >> 29;
    }
  }
  return hash;
}

}  // namespace

std::string_view name_of(PictureCondition condition) {
  switch (condition) {
    case PictureCondition::normal: return "normal";
    case PictureCondition::frozen: return "frozen";
    case PictureCondition::covered: return "covered";
    case PictureCondition::white_out: return "white-out";
  }
  return "unknown";
}

ConditionSample sample_picture(const PictureView& picture) {
  const auto channel = brightness_of(picture.layout);
  const auto& plane = picture.planes[0];
  std::array<int, kColumns * kRows> places{};
  for (int y = 0; y < kRows * kSamples; ++y) {
    const auto* row = plane.data + spread_over(y, kRows * kSamples, picture.height) * plane.stride + channel.offset;
    auto* place = places.data() + static_cast<std::size_t>(y / kSamples) * kColumns;
    for (int x = 0; x < kColumns * kSamples; ++x)
      place[x / kSamples] += row[spread_over(x, kColumns * kSamples, picture.width) * channel.step];
  }
  const auto twentieth = places.begin() + kColumns * kRows / 20;
  std::nth_element(places.begin(), twentieth, places.end());
  constexpr int kPerPlace = kSamples * kSamples;
  return {fingerprint_of(picture), *std::max_element(places.begin(), places.end()) / kPerPlace, *twentieth / kPerPlace};
}

PictureCondition ConditionWatch::observe(const ConditionSample& sample, Instant now) {
  auto seen = PictureCondition::normal;
  if (sample.brightest < kDark)
    seen = PictureCondition::covered;
  else if (sample.dim >= kWhiteOut)
    seen = PictureCondition::white_out;
  else if (last_ && last_->fingerprint == sample.fingerprint)
    seen = PictureCondition::frozen;
  // Frozen since the previous sample, when the picture last differed.
  if (seen != seen_ || seen == PictureCondition::normal) since_ = seen == PictureCondition::frozen ? sampled_at_ : now;
  seen_ = seen;
  last_ = sample;
  sampled_at_ = now;
  return now - since_ >= deadline_ ? seen : PictureCondition::normal;
}

void ConditionWatch::reopened() {
  last_.reset();
}

}  // namespace kasumi
