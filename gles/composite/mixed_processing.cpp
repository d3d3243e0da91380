#include "gles/composite/mixed_processing.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>
#include <utility>

#include "gles/composite/changed_blocks.hpp"
#include "gles/picture/wide_vectors.hpp"

namespace kasumi {
namespace {

constexpr int kSide = 8;  // of a block of samples

static_assert(kSide == kLanes);
using Row = Floats;
using Whole = Integers;
struct Block {
  Row rows[kSide];
};

// The constants of jpeg.frag.
constexpr float kReach = 8.25F;
constexpr float kMiddle = 128.0F / 255.0F;
constexpr float kZero = 32768.0F / 65535.0F;

// Vectors are only passed where this is inlined: no convention for calls matters.
#pragma GCC diagnostic ignored "-Wpsabi"
#define KASUMI_INLINED [[gnu::always_inline]] inline

KASUMI_INLINED Row held(Row value, float least, float most) {
  value = value < least ? Row{} + least : value;
  return value > most ? Row{} + most : value;
}
KASUMI_INLINED Whole truncated(Row value) {
  return __builtin_convertvector(value, Whole);
}
KASUMI_INLINED Row in_levels(Row value) {
  value = value * 255.0F + 0.53F;
  const Row whole = __builtin_convertvector(truncated(value), Row);
  return (value < whole ? whole - 1.0F : whole) * (1.0F / 255.0F);
}
// As a texture of 16 bits between two passes keeps it.
KASUMI_INLINED Row kept(Row value) {
  const Row bits =
      __builtin_convertvector(truncated(held(value * (1.0F / kReach) + kZero, 0.0F, 1.0F) * 65535.0F + 0.5F), Row);
  return (bits * (1.0F / 65535.0F) - kZero) * kReach;
}
KASUMI_INLINED Whole bytes_of(Row value) {
  return truncated(255.0F * held(value, 0.0F, 1.0F) + 0.5F);
}

// Half of its values, each for two pixels.
KASUMI_INLINED Row twice(Row values, int half) {
  return half == 0 ? __builtin_shufflevector(values, values, 0, 0, 1, 1, 2, 2, 3, 3)
                   : __builtin_shufflevector(values, values, 4, 4, 5, 5, 6, 6, 7, 7);
}

// Factors of the transform: by order, then place; and the reverse.
struct Cosines {
  Block by_order, by_place;
  Cosines() {
    for (int order = 0; order < kSide; ++order)
      for (int place = 0; place < kSide; ++place) {
        const double wave = std::cos((2.0 * place + 1.0) * order * std::numbers::pi / 16.0);
        by_place.rows[place][order] = by_order.rows[order][place] =
            static_cast<float>((order == 0 ? std::sqrt(0.125) : 0.5) * wave);
      }
  }
};

// a = a b or b a, an element's sum in the order of jpeg.frag's.
KASUMI_INLINED void times(const Block& a, const Block& b, Block& product) {
  for (int y = 0; y < kSide; ++y) {
    Row sum{};
    for (int i = 0; i < kSide; ++i) sum += a.rows[y][i] * b.rows[i];
    product.rows[y] = sum;
  }
}
KASUMI_INLINED void keep(Block& block) {
  for (Row& row : block.rows) row = kept(row);
}

// The steps that a block's coefficients are rounded to, 1 at full scale.
Block steps_of(const std::array<std::uint16_t, 64>& steps) {
  Block sizes;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      sizes.rows[y][x] =
          static_cast<float>(std::clamp<int>(steps[static_cast<std::size_t>(y * kSide + x)], 1, 255)) / 255.0F;
  return sizes;
}

// Samples about 0 to what is left of them, but for the inverse along rows.
void round(Block& samples, const Block& steps) {
  static const Cosines kCosines;
  Block turned, coefficients;
  times(samples, kCosines.by_place, turned);
  keep(turned);
  times(kCosines.by_order, turned, coefficients);
  for (int y = 0; y < kSide; ++y) {
    const Row value = coefficients.rows[y], size = steps.rows[y];
    const Row count = (value < 0.0F ? -value : value) / size + 0.5005F;
    const Row rounded = __builtin_convertvector(truncated(count), Row) * size;
    coefficients.rows[y] = kept(value < 0.0F ? -rounded : rounded);
  }
  times(kCosines.by_place, coefficients, turned);
  keep(turned);
  times(turned, kCosines.by_order, samples);
}

float luma_of(const glm::u8vec4& pixel) {
  return (0.299F * static_cast<float>(pixel.x) + 0.587F * static_cast<float>(pixel.y) +
          0.114F * static_cast<float>(pixel.z)) *
         (1.0F / 255.0F);
}

// The runs of these boxes' pixels that lie in others, too, in pixels of the picture.
std::vector<PixelBox> common(const std::vector<PixelBox>& boxes, const std::vector<PixelBox>& others,
                             const PixelBox& part) {
  Image<std::uint8_t> mask(part.right - part.left, part.bottom - part.top, 0);
  for (const PixelBox& box : others)
    for (int y = box.top; y < box.bottom; ++y)
      std::fill_n(&mask.at(box.left - part.left, y - part.top), box.right - box.left, std::uint8_t{1});
  std::vector<PixelBox> runs;
  for (const PixelBox& box : boxes)
    for (int y = box.top; y < box.bottom; ++y) {
      const std::uint8_t* row = mask.row(y - part.top) - part.left;
      for (int x = box.left; x < box.right;) {
        const int first = x;
        while (x < box.right && row[x] == row[first]) ++x;
        if (row[first]) runs.push_back({first, y, x, y + 1});
      }
    }
  return runs;
}

}  // namespace

MixedProcessing::MixedProcessing(const ObjectFootprint& object, ProcessingSteps options)
    : object_(object), options_(std::move(options)), part_(blocks_around(object.changed)) {
  BlockMap all = blocks_of(part_, object.changed);
  const BlockMap live = live_blocks_of(part_, object.changed, object.covered);
  all_ = all_or_live(rectangles_of(all));
  live_ = all_or_live(rectangles_of(live));
  for (std::size_t i = 0; i < all.elements().size(); ++i)
    if (live.elements()[i]) all.elements()[i] = 0;
  kept_blocks_ = rectangles_of(all);
}

MixedProcessing::Blocks MixedProcessing::all_or_live(const std::vector<PixelBox>& blocks) const {
  Blocks found;
  found.blocks = blocks;
  for (const PixelBox& block : blocks) {
    const PixelBox box = with_neighbours(block, part_, object_.picture);
    found.pixels.push_back({std::max(box.left, part_.left), std::max(box.top, part_.top),
                            std::min(box.right, part_.right), std::min(box.bottom, part_.bottom)});
  }
  found.covered = common(object_.covered, found.pixels, part_);
  return found;
}

bool MixedProcessing::is_for(const ObjectFootprint& object, const ProcessingSteps& options) const {
  const auto same_steps = [&] {
    return options.jpeg && options_.jpeg ? *options.jpeg == *options_.jpeg : options.jpeg == options_.jpeg;
  };
  return object == object_ && options.sharpening == options_.sharpening &&
         options.shared_pixels == options_.shared_pixels && same_steps();
}

glm::ivec2 MixedProcessing::last() const {
  return glm::min(object_.picture, glm::ivec2{part_.right, part_.bottom}) - glm::ivec2{part_.left, part_.top} - 1;
}

const MixedProcessing::Wanted& MixedProcessing::begin(std::size_t pattern, std::uint64_t drawing) {
  pattern_ = pattern;
  drawing_ = drawing;
  only_live_ = drawing > 0 && kept_[pattern].drawing == drawing;
  return only_live_ ? live_ : all_;
}

void MixedProcessing::apply(Image<glm::u8vec4>& picture, Image<glm::u8vec4>& composite) {
  const auto& blocks = only_live_ ? live_.blocks : all_.blocks;
  run_by_widest([&] {
    if (options_.sharpening > 0.0) sharpen(picture, composite);
    if (options_.jpeg)
      for (const PixelBox& row : blocks)
        for (int left = row.left; left < row.right; left += kBlock_px) round_block(left, row.top, composite);
  });

  const glm::ivec2 end = last() + 1;
  const auto each_row = [&](const std::vector<PixelBox>& boxes, auto&& work) {
    for (const PixelBox& box : boxes)
      for (int y = box.top; y < std::min(box.bottom, end.y); ++y) work(y, box.left, std::min(box.right, end.x));
  };
  each_row(blocks, [&](int y, int left, int right) {
    const glm::u8vec4* from = composite.row(y);
    glm::u8vec4* to = picture.row(part_.top + y) + part_.left;
    for (int x = left; x < right; ++x)
      if (from[x].w > 0) to[x] = from[x];
  });
  Kept& kept = kept_[pattern_];
  if (only_live_)
    each_row(kept_blocks_, [&](int y, int left, int right) {
      std::copy_n(kept.pixels.row(y) + left, right - left, picture.row(part_.top + y) + part_.left + left);
    });
  if (only_live_ || drawing_ == 0) return;
  if (kept.pixels.empty()) kept.pixels = Image<glm::u8vec4>(composite.width(), composite.height());
  each_row(kept_blocks_, [&](int y, int left, int right) {
    std::copy_n(composite.row(y) + left, right - left, kept.pixels.row(y) + left);
  });
  kept.drawing = drawing_;
}

void MixedProcessing::sharpen(const Image<glm::u8vec4>& camera, Image<glm::u8vec4>& composite) {
  const int width = composite.width(), height = composite.height();
  const glm::ivec2 last_px = last();
  if (luma_.empty()) luma_ = camera_luma_ = Image<float>(width + 2, height);
  for (const PixelBox& box : only_live_ ? live_.pixels : all_.pixels)
    for (int y = box.top - part_.top; y < box.bottom - part_.top; ++y) {
      const int left = box.left - part_.left, right = box.right - part_.left;
      const auto fill = [&](const glm::u8vec4* pixels, float* luma) {
        for (int x = left; x < right; ++x) luma[x] = luma_of(pixels[x]);
        // The picture's last pixels are repeated.
        if (left == 0) luma[-1] = luma[0];
        if (right > last_px.x) luma[last_px.x + 1] = luma[last_px.x];
      };
      fill(composite.row(y), luma_.row(y) + 1);
      fill(camera.row(part_.top + y) + part_.left, camera_luma_.row(y) + 1);
    }
  for (const PixelBox& row : only_live_ ? live_.blocks : all_.blocks)
    for (int y = row.top; y < std::min(row.bottom, last_px.y + 1); ++y)
      sharpen_row(y, row.left, std::min(row.right, last_px.x + 1), composite);
}

void MixedProcessing::sharpen_row(int y, int left, int right, Image<glm::u8vec4>& composite) const {
  const auto amount = static_cast<float>(options_.sharpening);
  const int above = std::max(y - 1, 0), below = std::min(y + 1, last().y);
  struct Rows {
    const float *above, *here, *below;
    Rows(const Image<float>& of, int up, int now, int down)
        : above(of.row(up) + 1), here(of.row(now) + 1), below(of.row(down) + 1) {}
    float detail(int x) const {
      const auto along = [x](const float* row) { return row[x - 1] + 2.0F * row[x] + row[x + 1]; };
      return here[x] - (along(above) + 2.0F * along(here) + along(below)) * (1.0F / 16.0F);
    }
  };
  const Rows ours(luma_, above, y, below), theirs(camera_luma_, above, y, below);
  const auto lesser = [](float a, float b) { return a < b ? a : b; };
  const auto larger = [](float a, float b) { return a > b ? a : b; };
  glm::u8vec4* pixels = composite.row(y);
  for (int x = left; x < right; ++x) {
    const float share = static_cast<float>(pixels[x].w) * (1.0F / 255.0F), luma = ours.here[x];
    float more = amount * (ours.detail(x) - (1.0F - share) * theirs.detail(x));
    const float least =
        lesser(lesser(lesser(luma, ours.here[x + 1]), lesser(ours.here[x - 1], ours.above[x])), ours.below[x]);
    const float most =
        larger(larger(larger(luma, ours.here[x + 1]), larger(ours.here[x - 1], ours.above[x])), ours.below[x]);
    const float over = 0.25F * amount * (most - least);
    more = lesser(larger(more, lesser(least - over - luma, 0.0F)), larger(most + over - luma, 0.0F));
    const auto sharp = [&](std::uint8_t value) {
      const float sum = static_cast<float>(value) / 255.0F + more;
      return static_cast<std::uint8_t>(static_cast<std::int32_t>(255.0F * lesser(larger(sum, 0.0F), 1.0F) + 0.5F));
    };
    pixels[x] = {sharp(pixels[x].x), sharp(pixels[x].y), sharp(pixels[x].z), pixels[x].w};
  }
}

void MixedProcessing::round_block(int left, int top, Image<glm::u8vec4>& composite) const {
  const glm::ivec2 last_px = last();
  constexpr int kHalves = kBlock_px / kSide;  // vectors in a row of pixels
  Row rgb[3][kBlock_px][kHalves];
  for (int y = 0; y < kBlock_px; ++y) {
    const glm::u8vec4* row = composite.row(std::min(top + y, last_px.y));
    for (int half = 0; half < kHalves; ++half) {
      const int first = left + half * kSide;
      Whole pixels;
      if (first + kSide - 1 <= last_px.x)
        std::memcpy(&pixels, row + first, sizeof pixels);
      else
        for (int x = 0; x < kSide; ++x) pixels[x] = std::bit_cast<std::int32_t>(row[std::min(first + x, last_px.x)]);
      for (int c = 0; c < 3; ++c) rgb[c][y][half] = __builtin_convertvector((pixels >> (8 * c)) & 255, Row);
    }
  }

  const Block luma_steps = steps_of(options_.jpeg->luma), chroma_steps = steps_of(options_.jpeg->chroma);
  Row luma[kBlock_px][kHalves];
  for (int half = 0; half < kHalves; ++half)
    for (int down = 0; down < kBlock_px; down += kSide) {
      Block block;
      for (int y = 0; y < kSide; ++y) {
        const int row = down + y;
        block.rows[y] =
            in_levels((0.299F * rgb[0][row][half] + 0.587F * rgb[1][row][half] + 0.114F * rgb[2][row][half]) *
                      (1.0F / 255.0F)) -
            kMiddle;
      }
      round(block, luma_steps);
      for (int y = 0; y < kSide; ++y) luma[down + y][half] = block.rows[y];
    }

  const glm::ivec2 shared = options_.shared_pixels;
  const float share = 1.0F / static_cast<float>(shared.x * shared.y);
  Row blue[kBlock_px][kHalves], red[kBlock_px][kHalves];
  for (int down = 0; down < kBlock_px / shared.y; down += kSide)
    for (int across = 0; across < kBlock_px / shared.x / kSide; ++across) {
      Block b, r;
      for (int y = 0; y < kSide; ++y) {
        Row mean[3];
        for (int c = 0; c < 3; ++c) {
          Row sum[2]{};
          for (int v = 0; v < shared.y; ++v)
            for (int half = 0; half < shared.x; ++half)
              sum[half] += rgb[c][(down + y) * shared.y + v][across * shared.x + half];
          if (shared.x == 2)
            sum[0] = __builtin_shufflevector(sum[0], sum[1], 0, 2, 4, 6, 8, 10, 12, 14) +
                     __builtin_shufflevector(sum[0], sum[1], 1, 3, 5, 7, 9, 11, 13, 15);
          mean[c] = sum[0] * (share / 255.0F);
        }
        b.rows[y] = in_levels(-0.168736F * mean[0] - 0.331264F * mean[1] + 0.5F * mean[2]);
        r.rows[y] = in_levels(0.5F * mean[0] - 0.418688F * mean[1] - 0.081312F * mean[2]);
      }
      round(b, chroma_steps);
      round(r, chroma_steps);
      for (int y = 0; y < kSide; ++y) {
        blue[down + y][across] = in_levels(kept(b.rows[y]));
        red[down + y][across] = in_levels(kept(r.rows[y]));
      }
    }

  for (int y = 0; y < kBlock_px && top + y <= last_px.y; ++y)
    for (int half = 0; half < kHalves; ++half) {
      const int count = std::min(last_px.x + 1 - left - half * kSide, kSide);
      if (count <= 0) break;
      const Row light = held(in_levels(luma[y][half]) + kMiddle, 0.0F, 1.0F);
      Row b = blue[y / shared.y][shared.x == 2 ? 0 : half], r = red[y / shared.y][shared.x == 2 ? 0 : half];
      if (shared.x == 2) {
        b = twice(b, half);
        r = twice(r, half);
      }
      glm::u8vec4* to = composite.row(top + y) + left + half * kSide;
      Whole pixels{};
      std::memcpy(&pixels, to, static_cast<std::size_t>(count) * sizeof *to);
      const Whole alpha = pixels & static_cast<std::int32_t>(0xff000000);
      const Whole rounded = bytes_of(light + 1.402F * r) | bytes_of(light - 0.344136F * b - 0.714136F * r) << 8 |
                            bytes_of(light + 1.772F * b) << 16 | alpha;
      pixels = alpha == 0 ? pixels : rounded;
      std::memcpy(to, &pixels, static_cast<std::size_t>(count) * sizeof *to);
    }
}

}  // namespace kasumi
