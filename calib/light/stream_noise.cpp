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
#include "calib/light/jpeg_block.hpp"

namespace kasumi {
namespace {

constexpr int kSide = kBlockSide, kMargin = 1, kPatch = kSide + 2 * kMargin;
constexpr std::size_t kPixelLevels = 8, kBlocksOfLevel = 160, kFewestBlocks = 24;
const glm::dvec3 kLuma{0.299, 0.587, 0.114};

using Block = JpegBlock;
using Patch = std::array<glm::dvec3, kPatch * kPatch>;  // a block and its neighbours

double luma_of(const Rgb8& pixel) {
  return glm::dot(kLuma, glm::dvec3(pixel));
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

struct Place {
  Patch light{};
  Block coefficients{};  // of its luma, before JPEG rounded it: levels of 255, not known to better than the steps
};

struct Level {
  double variance = 0.0;  // median over all of its blocks
  std::vector<Place> places;
};

// Where in its step each coefficient lay that JPEG rounded: anywhere. How often noise takes it over the step's end
// depends on that, and what is left after rounding lies in the middle of all steps, where noise does least. What is
// rounded to 0 stays there: of even areas, which most blocks are, it is next to nothing.
void place_within_steps(Block& coefficients, const BlockSteps& steps, std::mt19937_64& random) {
  std::uniform_real_distribution<double> within(-0.5, 0.5);
  for (std::size_t i = 0; i < coefficients.size(); ++i) {
    const double step = step_of(steps, i), rounded = std::round(coefficients[i] / step);
    if (rounded != 0.0) coefficients[i] = step * (rounded + within(random));
  }
}

class StreamSimulation {
 public:
  StreamSimulation(const Response& response, const StreamProcessing& processing)
      : response_(response), processing_(processing) {}

  // In as many pictures as were seen: the median of what happens seldom depends on their number. The same random
  // numbers for all E and r, so that the misfit is smooth.
  double variance(const Level& level, std::size_t pictures, double electrons, double read) const {
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    const glm::dvec3 share = processing_.white_balance / electrons;
    std::vector<double> variances;
    std::vector<Block> seen(pictures);
    for (const Place& place : level.places) {
      const Block clean = sharpened(encoded(place.light));
      for (Block& block : seen) {
        Patch noisy = place.light;
        for (glm::dvec3& light : noisy) {
          const glm::dvec3 deviation = glm::sqrt(share * light + share * share * read * read);
          light += deviation * glm::dvec3(normal(random), normal(random), normal(random));
        }
        block = sharpened(encoded(noisy));
        if (processing_.jpeg) block = coded(place, clean, block);
        for (double& value : block) value = std::round(value);
      }
      variances.push_back(variance_of(seen));
    }
    return median(std::move(variances));
  }

 private:
  Patch encoded(Patch light) const {
    for (glm::dvec3& value : light) value = 255.0 * response_.to_encoded(glm::clamp(value, 0.0, 1.0));
    return light;
  }

  Block sharpened(const Patch& encoded) const {
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
    return block;
  }

  Block coded(const Place& place, const Block& clean, Block noisy) const {
    for (std::size_t i = 0; i < noisy.size(); ++i) noisy[i] -= clean[i];
    Block coefficients = coefficients_of(noisy);
    for (std::size_t i = 0; i < coefficients.size(); ++i) {
      const double step = step_of(processing_.jpeg->luma, i);
      coefficients[i] = step * std::round((place.coefficients[i] + coefficients[i]) / step);
    }
    return samples_of(coefficients);
  }

  const Response& response_;
  const StreamProcessing& processing_;
};

std::vector<Level> levels_of(std::span<const Image<Rgb8>> pictures, const Response& response, const JpegSteps* jpeg) {
  const int width = pictures[0].width(), height = pictures[0].height();
  struct Found {
    double luma, variance;
    int x, y;
  };
  std::vector<Found> found;
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
      found.push_back({mean, variance_of(blocks), x, y});
    }
  std::vector<Level> levels;
  std::mt19937_64 random(11);
  for (std::size_t i = 0; i < kPixelLevels; ++i) {
    const double from = 255.0 * static_cast<double>(i) / kPixelLevels,
                 to = 255.0 * static_cast<double>(i + 1) / kPixelLevels;
    std::vector<Found> inside;
    std::ranges::copy_if(found, std::back_inserter(inside),
                         [&](const Found& f) { return f.luma >= from && f.luma < to; });
    if (inside.size() < kFewestBlocks) continue;
    Level level;
    std::vector<double> variances;
    for (const auto& one : inside) variances.push_back(one.variance);
    level.variance = median(std::move(variances));
    std::shuffle(inside.begin(), inside.end(), random);
    inside.resize(std::min(inside.size(), kBlocksOfLevel));
    for (const auto& one : inside) {
      Place place;
      Block luma{};
      for (int v = 0; v < kPatch; ++v)
        for (int u = 0; u < kPatch; ++u) {
          glm::dvec3 mean{0.0};
          for (const auto& picture : pictures)
            mean +=
                glm::dvec3(picture.at(one.x + u - kMargin, one.y + v - kMargin)) / static_cast<double>(pictures.size());
          place.light[static_cast<std::size_t>(v * kPatch + u)] = response.to_light(mean / 255.0);
          const int x = u - kMargin, y = v - kMargin;
          if (std::min(x, y) >= 0 && std::max(x, y) < kSide)
            luma[static_cast<std::size_t>(kSide * y + x)] = glm::dot(kLuma, mean) - 128.0;
        }
      place.coefficients = coefficients_of(luma);
      if (jpeg) place_within_steps(place.coefficients, jpeg->luma, random);
      level.places.push_back(place);
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
  auto levels = levels_of(pictures, response, processing.jpeg.get());
  std::erase_if(levels, [](const Level& level) { return level.variance < kNothing; });
  if (levels.empty()) return std::nullopt;
  const StreamSimulation simulation(response, processing);
  const auto misfit = [&](double electrons, double read) {
    double sum = 0.0;
    for (const auto& level : levels)
      sum += std::pow(std::log((simulation.variance(level, pictures.size(), electrons, read) + kNothing) /
                               (level.variance + kNothing)),
                      2);
    return std::sqrt(sum / static_cast<double>(levels.size()));
  };
  StreamNoise best{0.0, 0.0, 1e9};
  // By factors, then finer around the best. Only dark levels separate read noise from shot noise.
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
