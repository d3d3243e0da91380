#include "gles/object/mixed_processing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "gles/object/changed_blocks.hpp"

namespace kasumi {
namespace {

constexpr int kSide = 8;  // of a block of samples

using Block = std::array<std::array<float, kSide>, kSide>;  // rows first

// The constants of jpeg.frag.
constexpr float kReach = 8.25F;
constexpr float kMiddle = 128.0F / 255.0F;
constexpr float kZero = 32768.0F / 65535.0F;

// std::floor() would be a call.
float whole_below(float value) {
  const auto whole = static_cast<float>(static_cast<int>(value));
  return value < whole ? whole - 1.0F : whole;
}
float in_levels(float value) {
  return whole_below(value * 255.0F + 0.53F) * (1.0F / 255.0F);
}
// As a texture of 16 bits between two passes keeps it.
float kept(float value) {
  const float held = std::min(std::max(value * (1.0F / kReach) + kZero, 0.0F), 1.0F);
  const auto bits = static_cast<float>(static_cast<int>(held * 65535.0F + 0.5F));
  return (bits * (1.0F / 65535.0F) - kZero) * kReach;
}

// cosines[order][place], with the factors of the transform.
Block make_cosines() {
  Block cosines;
  for (std::size_t order = 0; order < kSide; ++order)
    for (std::size_t place = 0; place < kSide; ++place) {
      const double wave =
          std::cos((2.0 * static_cast<double>(place) + 1.0) * static_cast<double>(order) * std::numbers::pi / 16.0);
      cosines[order][place] = static_cast<float>((order == 0 ? std::sqrt(0.125) : 0.5) * wave);
    }
  return cosines;
}
Block transposed(const Block& block) {
  Block turned;
  for (std::size_t y = 0; y < kSide; ++y)
    for (std::size_t x = 0; x < kSide; ++x) turned[x][y] = block[y][x];
  return turned;
}

// The product a b, an element's sum in the order of jpeg.frag's.
Block product(const Block& a, const Block& b) {
  Block sum{};
  for (std::size_t y = 0; y < kSide; ++y)
    for (std::size_t i = 0; i < kSide; ++i)
      for (std::size_t x = 0; x < kSide; ++x) sum[y][x] += a[y][i] * b[i][x];
  return sum;
}
Block kept(Block block) {
  for (auto& row : block)
    for (float& value : row) value = kept(value);
  return block;
}

// The steps that a block's coefficients are rounded to, 1 at full scale.
Block steps_of(const std::array<std::uint16_t, 64>& steps) {
  Block sizes;
  for (std::size_t i = 0; i < steps.size(); ++i)
    sizes[i / kSide][i % kSide] = static_cast<float>(std::clamp<int>(steps[i], 1, 255)) / 255.0F;
  return sizes;
}

// Samples about 0 to what is left of them, but for the inverse along rows.
Block rounded(const Block& samples, const Block& steps) {
  static const Block kCosines = make_cosines(), kTurned = transposed(kCosines);
  Block coefficients = product(kCosines, kept(product(samples, kTurned)));
  for (std::size_t y = 0; y < kSide; ++y)
    for (std::size_t x = 0; x < kSide; ++x) {
      const float value = coefficients[y][x], size = steps[y][x];
      const auto count = static_cast<float>(static_cast<int>(std::abs(value) / size + 0.5005F));
      coefficients[y][x] = std::copysign(count * size, value);
    }
  const Block columns = kept(product(kTurned, kept(coefficients)));
  return product(columns, kCosines);
}

float luma_of(const glm::u8vec4& pixel) {
  return (0.299F * static_cast<float>(pixel.x) + 0.587F * static_cast<float>(pixel.y) +
          0.114F * static_cast<float>(pixel.z)) *
         (1.0F / 255.0F);
}
std::uint8_t byte_of(float value) {
  return static_cast<std::uint8_t>(static_cast<int>(255.0F * std::min(std::max(value, 0.0F), 1.0F) + 0.5F));
}

}  // namespace

MixedProcessing::MixedProcessing(const ObjectInPicture& object, ProcessingOptions options)
    : object_(object), options_(std::move(options)), part_(blocks_around(object.changed)) {
  blocks_ = rectangles_of(blocks_of(part_, object.changed));
}

bool MixedProcessing::is_for(const ObjectInPicture& object, const ProcessingOptions& options) const {
  const auto same_steps = [&] {
    return options.jpeg && options_.jpeg ? *options.jpeg == *options_.jpeg : options.jpeg == options_.jpeg;
  };
  return object == object_ && options.sharpening == options_.sharpening &&
         options.shared_pixels == options_.shared_pixels && same_steps();
}

void MixedProcessing::apply(const Image<glm::u8vec4>& camera, Image<glm::u8vec4>& composite) {
  if (options_.sharpening > 0.0) sharpen(camera, composite);
  if (!options_.jpeg) return;
  sharpened_ = composite;
  for (const PixelBox& row : blocks_)
    for (int left = row.left; left < row.right; left += kBlock_px) round_block(left, row.top, sharpened_, composite);
}

void MixedProcessing::sharpen(const Image<glm::u8vec4>& camera, Image<glm::u8vec4>& composite) {
  const int width = composite.width(), height = composite.height();
  // The picture's last pixels are repeated.
  const int last_x = std::min(width, object_.picture.x - part_.left) - 1;
  const int last_y = std::min(height, object_.picture.y - part_.top) - 1;
  if (luma_.width() != width || luma_.height() != height) luma_ = camera_luma_ = Image<float>(width, height);
  for (int y = 0; y <= last_y; ++y) {
    const glm::u8vec4* ours = composite.row(y);
    const glm::u8vec4* theirs = camera.row(part_.top + y) + part_.left;
    float *luma = luma_.row(y), *camera_luma = camera_luma_.row(y);
    for (int x = 0; x <= last_x; ++x) {
      luma[x] = luma_of(ours[x]);
      camera_luma[x] = luma_of(theirs[x]);
    }
  }
  const auto amount = static_cast<float>(options_.sharpening);
  const auto sharpen_row = [&](int y, int left, int right) {
    const int above = std::max(y - 1, 0), below = std::min(y + 1, last_y);
    const auto detail = [&](const Image<float>& of, int x) {
      const int before = std::max(x - 1, 0), after = std::min(x + 1, last_x);
      const auto along = [&](int row) {
        const float* values = of.row(row);
        return values[before] + 2.0F * values[x] + values[after];
      };
      return of.at(x, y) - (along(above) + 2.0F * along(y) + along(below)) * (1.0F / 16.0F);
    };
    for (int x = left; x < right; ++x) {
      glm::u8vec4& pixel = composite.at(x, y);
      const float share = static_cast<float>(pixel.w) * (1.0F / 255.0F);
      const float luma = luma_.at(x, y);
      float more = amount * (detail(luma_, x) - (1.0F - share) * detail(camera_luma_, x));
      const auto beside = {luma, luma_.at(std::min(x + 1, last_x), y), luma_.at(std::max(x - 1, 0), y),
                           luma_.at(x, above), luma_.at(x, below)};
      const float least = std::min(beside), most = std::max(beside), over = 0.25F * amount * (most - least);
      more = std::clamp(more, std::min(least - over - luma, 0.0F), std::max(most + over - luma, 0.0F));
      const auto sharp = [&](std::uint8_t value) { return byte_of(static_cast<float>(value) / 255.0F + more); };
      pixel = {sharp(pixel.x), sharp(pixel.y), sharp(pixel.z), pixel.w};
    }
  };
  for (const PixelBox& row : blocks_)
    for (int y = row.top; y < std::min(row.bottom, last_y + 1); ++y)
      sharpen_row(y, row.left, std::min(row.right, last_x + 1));
}

void MixedProcessing::round_block(int left, int top, const Image<glm::u8vec4>& from, Image<glm::u8vec4>& to) const {
  const int last_x = std::min(from.width(), object_.picture.x - part_.left) - 1;
  const int last_y = std::min(from.height(), object_.picture.y - part_.top) - 1;
  const auto pixel = [&](int x, int y) { return from.at(std::min(left + x, last_x), std::min(top + y, last_y)); };
  constexpr std::size_t kWhole = kBlock_px;  // a side of a block of full resolution
  std::array<std::array<float, kWhole>, kWhole> luma, blue{}, red{};
  for (int y = 0; y < kBlock_px; ++y)
    for (int x = 0; x < kBlock_px; ++x) {
      luma[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] = in_levels(luma_of(pixel(x, y))) - kMiddle;
    }
  const Block luma_steps = steps_of(options_.jpeg->luma), chroma_steps = steps_of(options_.jpeg->chroma);
  Block block;
  for (std::size_t down = 0; down < kWhole; down += kSide)
    for (std::size_t across = 0; across < kWhole; across += kSide) {
      for (std::size_t y = 0; y < kSide; ++y) std::copy_n(&luma[down + y][across], kSide, block[y].begin());
      block = rounded(block, luma_steps);
      for (std::size_t y = 0; y < kSide; ++y) std::copy_n(block[y].begin(), kSide, &luma[down + y][across]);
    }

  const glm::ivec2 shared = options_.shared_pixels;
  const float share = 1.0F / static_cast<float>(shared.x * shared.y);
  for (int down = 0; down < kBlock_px / shared.y; down += kSide)
    for (int across = 0; across < kBlock_px / shared.x; across += kSide) {
      Block b, r;
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
          glm::vec3 rgb(0.0F);
          for (int v = 0; v < shared.y; ++v)
            for (int u = 0; u < shared.x; ++u)
              rgb += glm::vec3(pixel((across + x) * shared.x + u, (down + y) * shared.y + v));
          rgb *= share / 255.0F;
          const auto row = static_cast<std::size_t>(y), column = static_cast<std::size_t>(x);
          b[row][column] = in_levels(-0.168736F * rgb.x - 0.331264F * rgb.y + 0.5F * rgb.z);
          r[row][column] = in_levels(0.5F * rgb.x - 0.418688F * rgb.y - 0.081312F * rgb.z);
        }
      b = kept(rounded(b, chroma_steps));
      r = kept(rounded(r, chroma_steps));
      for (std::size_t y = 0; y < kSide; ++y)
        for (std::size_t x = 0; x < kSide; ++x) {
          blue[static_cast<std::size_t>(down) + y][static_cast<std::size_t>(across) + x] = in_levels(b[y][x]);
          red[static_cast<std::size_t>(down) + y][static_cast<std::size_t>(across) + x] = in_levels(r[y][x]);
        }
    }

  for (int y = 0; y < kBlock_px && top + y <= last_y; ++y)
    for (int x = 0; x < kBlock_px && left + x <= last_x; ++x) {
      glm::u8vec4& result = to.at(left + x, top + y);
      if (result.w == 0) continue;
      const auto row = static_cast<std::size_t>(y), column = static_cast<std::size_t>(x);
      const float light = std::clamp(in_levels(luma[row][column]) + kMiddle, 0.0F, 1.0F);
      const auto half_row = static_cast<std::size_t>(y / shared.y),
                 half_column = static_cast<std::size_t>(x / shared.x);
      const float b = blue[half_row][half_column], r = red[half_row][half_column];
      result = {byte_of(light + 1.402F * r), byte_of(light - 0.344136F * b - 0.714136F * r),
                byte_of(light + 1.772F * b), result.w};
    }
}

}  // namespace kasumi
