#include "calib/light/stream_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "base/statistics.hpp"
#include "base/units.hpp"

namespace kasumi {
namespace {

constexpr int kSide = 8, kMargin = 1, kPatch = kSide + 2 * kMargin;
constexpr std::size_t kLevels = 8, kBlocksOfLevel = 160, kFewestBlocks = 24, kRepeats = 4;
const glm::dvec3 kLuma{0.299, 0.587, 0.114};

using Block = std::array<double, kSide * kSide>;
using Patch = std::array<glm::dvec3, kPatch * kPatch>;  // a block and its neighbours

double luma_of(const Rgb8& pixel) {
  return glm::dot(kLuma, glm::dvec3(pixel));
}

// ITU-T T.81 A.3.3: rounded to the steps and back, levels of 255.
void round_block(Block& block, const std::array<std::uint16_t, 64>& steps) {
  static const auto kCosines = [] {
    std::array<double, 64> cosines{};
    for (std::size_t u = 0; u < 8; ++u)
      for (std::size_t i = 0; i < 8; ++i)
        cosines[8 * u + i] = (u == 0 ? std::sqrt(0.125) : 0.5) *
                             std::cos((2.0 * static_cast<double>(i) + 1.0) * static_cast<double>(u) * kPi / 16.0);
    return cosines;
  }();
  const auto multiplied = [](const Block& values, bool transposed, bool rows) {
    Block out{};
    for (std::size_t y = 0; y < 8; ++y)
      for (std::size_t x = 0; x < 8; ++x)
        for (std::size_t k = 0; k < 8; ++k) {
          const std::size_t to = rows ? x : y;
          const double weight = transposed ? kCosines[8 * k + to] : kCosines[8 * to + k];
          out[8 * y + x] += weight * (rows ? values[8 * y + k] : values[8 * k + x]);
        }
    return out;
  };
  for (double& value : block) value -= 128.0;
  Block coefficients = multiplied(multiplied(block, false, true), false, false);
  for (std::size_t i = 0; i < coefficients.size(); ++i) {
    const double step = std::max<double>(steps[i], 1.0);
    coefficients[i] = step * std::round(coefficients[i] / step);
  }
  block = multiplied(multiplied(coefficients, true, true), true, false);
  for (double& value : block) value += 128.0;
}

// Mean over a block's pixels of their variance from picture to picture.
double variance_of(std::span<const Block> blocks) {
  const double count = static_cast<double>(blocks.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < blocks[0].size(); ++i) {
    double mean = 0.0, square = 0.0;
    for (const auto& block : blocks) mean += block[i], square += block[i] * block[i];
    sum += (square - mean * mean / count) / (count - 1.0);
  }
  return sum / static_cast<double>(blocks[0].size());
}

struct Level {
  double variance = 0.0;  // median over all of its blocks
  std::vector<Patch> light;
};

class StreamSimulation {
 public:
  StreamSimulation(const Response& response, const StreamProcessing& processing)
      : response_(response), processing_(processing) {}

  // The same random numbers for all E and r, so that the misfit is smooth.
  double variance(const Level& level, double electrons, double read) const {
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    std::vector<double> variances;
    for (const Patch& light : level.light) {
      std::array<Block, kRepeats> seen;
      for (Block& block : seen) {
        std::array<glm::dvec3, kPatch * kPatch> encoded;
        for (std::size_t i = 0; i < light.size(); ++i) {
          const glm::dvec3 share = processing_.white_balance / electrons;
          const glm::dvec3 deviation = glm::sqrt(share * light[i] + share * share * read * read);
          const glm::dvec3 noisy = light[i] + deviation * glm::dvec3(normal(random), normal(random), normal(random));
          encoded[i] = 255.0 * response_.to_encoded(glm::clamp(noisy, 0.0, 1.0));
        }
        block = shown(encoded);
      }
      variances.push_back(variance_of(seen));
    }
    return median(std::move(variances));
  }

 private:
  Block shown(const Patch& encoded) const {
    Block block{};
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const auto at = [&](int u, int v) {
          return glm::dot(kLuma, encoded[static_cast<std::size_t>((y + kMargin + v) * kPatch + x + kMargin + u)]);
        };
        double around = 0.0;
        for (int v = -1; v <= 1; ++v)
          for (int u = -1; u <= 1; ++u) around += (2 - std::abs(u)) * (2 - std::abs(v)) / 16.0 * at(u, v);
        block[static_cast<std::size_t>(kSide * y + x)] = at(0, 0) + processing_.sharpening * (at(0, 0) - around);
      }
    if (processing_.jpeg) round_block(block, processing_.jpeg->luma);
    for (double& value : block) value = std::round(value);
    return block;
  }

  const Response& response_;
  const StreamProcessing& processing_;
};

std::vector<Level> levels_of(std::span<const Image<Rgb8>> pictures, const Response& response) {
  const int width = pictures[0].width(), height = pictures[0].height();
  struct Place {
    double luma, variance;
    int x, y;
  };
  std::vector<Place> places;
  std::vector<Block> blocks(pictures.size());
  for (int y = kSide; y + 2 * kSide <= height; y += kSide)
    for (int x = kSide; x + 2 * kSide <= width; x += kSide) {
      double sum = 0.0, most = 0.0;
      for (std::size_t k = 0; k < pictures.size(); ++k)
        for (int v = 0; v < kSide; ++v)
          for (int u = 0; u < kSide; ++u) {
            const double value = luma_of(pictures[k].at(x + u, y + v));
            blocks[k][static_cast<std::size_t>(kSide * v + u)] = value;
            sum += value;
            most = std::max(most, value);
          }
      const double mean = sum / static_cast<double>(blocks.size() * blocks[0].size());
      if (mean < 4.0 || most > 250.0) continue;
      places.push_back({mean, variance_of(blocks), x, y});
    }
  std::vector<Level> levels;
  std::mt19937_64 random(11);
  for (std::size_t i = 0; i < kLevels; ++i) {
    const double from = 255.0 * static_cast<double>(i) / kLevels, to = 255.0 * static_cast<double>(i + 1) / kLevels;
    std::vector<Place> inside;
    std::ranges::copy_if(places, std::back_inserter(inside),
                         [&](const Place& p) { return p.luma >= from && p.luma < to; });
    if (inside.size() < kFewestBlocks) continue;
    Level level;
    std::vector<double> variances;
    for (const auto& place : inside) variances.push_back(place.variance);
    level.variance = median(std::move(variances));
    std::shuffle(inside.begin(), inside.end(), random);
    inside.resize(std::min(inside.size(), kBlocksOfLevel));
    for (const auto& place : inside) {
      Patch patch{};
      for (int v = 0; v < kPatch; ++v)
        for (int u = 0; u < kPatch; ++u) {
          glm::dvec3 mean{0.0};
          for (const auto& picture : pictures)
            mean += glm::dvec3(picture.at(place.x + u - kMargin, place.y + v - kMargin));
          patch[static_cast<std::size_t>(v * kPatch + u)] =
              response.to_light(mean / (255.0 * static_cast<double>(pictures.size())));
        }
      level.light.push_back(patch);
    }
    levels.push_back(std::move(level));
  }
  return levels;
}

}  // namespace

std::optional<StreamNoise> fit_stream_noise(std::span<const Image<Rgb8>> pictures, const Response& response,
                                            const StreamProcessing& processing) {
  constexpr double kNothing = 0.02;  // of a level's square: what rounding alone may leave
  if (pictures.size() < 3) return std::nullopt;
  auto levels = levels_of(pictures, response);
  std::erase_if(levels, [](const Level& level) { return level.variance < kNothing; });
  if (levels.empty()) return std::nullopt;
  const StreamSimulation simulation(response, processing);
  const auto misfit = [&](double electrons, double read) {
    double sum = 0.0;
    for (const auto& level : levels)
      sum +=
          std::pow(std::log((simulation.variance(level, electrons, read) + kNothing) / (level.variance + kNothing)), 2);
    return std::sqrt(sum / static_cast<double>(levels.size()));
  };
  StreamNoise best{0.0, 0.0, 1e9};
  // By factors, then finer around the best. Read noise is told from shot noise by the dark levels alone.
  const auto search = [&](double from, double to, int steps, std::span<const double> reads) {
    for (int i = 0; i <= steps; ++i)
      for (const double read : reads) {
        const double electrons = from * std::pow(to / from, static_cast<double>(i) / steps);
        if (const double off = misfit(electrons, read); off < best.misfit) best = {electrons, read, off};
      }
  };
  search(300.0, 100e3, 12, std::array{3.0});
  const double coarse = best.full_scale_electrons;
  search(coarse / 1.6, coarse * 1.6, 8, std::array{0.0, 3.0, 6.0, 12.0});
  const double finer = best.full_scale_electrons, read = best.read_electrons;
  search(finer / 1.1, finer * 1.1, 4, std::array{0.5 * read, read, 1.5 * read});
  return best;
}

}  // namespace kasumi
