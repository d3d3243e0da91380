#include "estimator/passers/light_mix.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace kasumi {
namespace {

using Eigen::MatrixXf;
using Eigen::VectorXf;

constexpr int kWindow = 16, kStep = 8;              // cells
constexpr int kMostComponents = 6;                  // of pictures
constexpr float kLeastVariance = 0.05F;             // steps of 255, squared, in the mean: less is noise
constexpr float kWider = 2.0F, kWiderOfAll = 4.0F;  // than the pictures scatter may the light be
constexpr float kFalls = 0.3F;                      // across a window, relative
constexpr float kTint = 0.1F;                       // of red and blue, relative
constexpr float kOutlier = 3.5F;                    // in a cell's own deviations of three channels
constexpr int kRounds = 5;                          // of reweighting: outliers' weights settle

}  // namespace

LightMix::Window LightMix::window_of(int column, int row, int columns, int rows,
                                     const std::vector<RememberedFrame>& pictures) const {
  Window made{column, row, columns, rows, 0, 0, {}, {}, {}, {}, {}};
  const auto count = static_cast<Eigen::Index>(pictures.size());
  const Eigen::Index size = 3L * columns * rows;
  MatrixXf seen(size, count);
  for (Eigen::Index k = 0; k < count; ++k)
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < columns; ++x) {
        const glm::vec3 steps =
            steps_.at(column + x, row + y) * pictures[static_cast<std::size_t>(k)].light.at(column + x, row + y);
        for (int c = 0; c < 3; ++c) seen(3L * (y * columns + x) + c, k) = steps[c];
      }
  const Eigen::SelfAdjointEigenSolver<MatrixXf> eigen(seen.transpose() * seen);
  std::vector<VectorXf> basis;
  for (Eigen::Index k = 0; k < count && made.of_pictures < kMostComponents; ++k) {
    const float strength = eigen.eigenvalues()(count - 1 - k);
    if (strength < kLeastVariance * static_cast<float>(size * count)) break;
    const VectorXf vector = eigen.eigenvectors().col(count - 1 - k);
    const float scale = std::sqrt(strength);
    basis.push_back(seen * vector / scale);
    for (Eigen::Index i = 0; i < count; ++i) made.made_of.push_back(vector(i) / scale);
    made.scale.push_back(scale);
    ++made.of_pictures;
  }
  if (made.of_pictures > 0)
    for (const bool across : {true, false}) {
      VectorXf falls = basis[0];
      for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
          const float at = across ? (static_cast<float>(x) + 0.5F) / static_cast<float>(columns) - 0.5F
                                  : (static_cast<float>(y) + 0.5F) / static_cast<float>(rows) - 0.5F;
          falls.segment<3>(3L * (y * columns + x)) *= at;
        }
      basis.push_back(falls);
      ++made.more;
    }
  if (made.of_pictures > 0)
    for (const Eigen::Index channel : {0, 2}) {
      VectorXf tint = VectorXf::Zero(size);
      for (Eigen::Index i = channel; i < size; i += 3) tint(i) = basis[0](i);
      basis.push_back(tint);
      ++made.more;
    }
  for (const VectorXf& one : basis) {
    made.basis.insert(made.basis.end(), one.data(), one.data() + size);
    for (int y = 0; y < rows; ++y)
      for (int x = y % 2; x < columns; x += 2) {
        const float* of = one.data() + 3L * (y * columns + x);
        made.fitted.insert(made.fitted.end(), of, of + 3);
      }
  }
  return made;
}

void LightMix::learn(const std::vector<RememberedFrame>& pictures, const Tone& tone) {
  windows_.clear();
  pictures_ = pictures.size();
  if (pictures.empty()) return;
  const int columns = pictures[0].light.width(), rows = pictures[0].light.height();
  steps_ = Image<glm::vec3>(columns, rows);
  for (std::size_t i = 0; i < steps_.elements().size(); ++i) {
    glm::vec3 mean{0};
    for (const auto& one : pictures) mean += one.light.elements()[i] / static_cast<float>(pictures.size());
    mean = glm::max(mean, glm::vec3{1e-3F});
    steps_.elements()[i] = (tone.to_code(1.1F * mean) - tone.to_code(0.9F * mean)) / (0.2F * mean);
  }
  const auto starts = [](int size) {
    std::vector<int> from;
    for (int at = 0; at + kWindow < size; at += kStep) from.push_back(at);
    from.push_back(std::max(0, size - kWindow));
    return from;
  };
  windows_.push_back(window_of(0, 0, columns, rows, pictures));
  for (const int row : starts(rows))
    for (const int column : starts(columns))
      windows_.push_back(window_of(column, row, std::min(kWindow, columns), std::min(kWindow, rows), pictures));
}

// Coefficients of the window's components: robust, and regularised towards the shares found `before`.
std::vector<float> LightMix::fit(const Window& window, const std::vector<float>& before) const {
  const int components = window.of_pictures + window.more;
  if (components == 0) return {};
  const auto size = static_cast<Eigen::Index>(window.fitted.size()) / components, cells = size / 3;
  const Eigen::Map<const MatrixXf> basis(window.fitted.data(), size, components);
  VectorXf now(size), weight(cells);
  for (Eigen::Index i = 0, y = 0; y < window.rows; ++y)
    for (int x = static_cast<int>(y % 2); x < window.columns; x += 2, ++i) {
      const glm::vec3& is = now_.at(window.column + x, window.row + static_cast<int>(y));
      now.segment<3>(3 * i) << is.r, is.g, is.b;
      weight(i) = weight_.at(window.column + x, window.row + static_cast<int>(y));
    }
  VectorXf prior = VectorXf::Zero(components), precision(components);
  const bool whole = &window == windows_.data();
  for (int k = 0; k < window.of_pictures; ++k) {
    const auto n = static_cast<std::size_t>(k);
    for (std::size_t i = 0; i < before.size(); ++i)
      prior(k) += window.scale[n] * window.scale[n] * window.made_of[n * pictures_ + i] * before[i];
    const float spread = (whole ? kWiderOfAll : kWider) * window.scale[n] / std::sqrt(static_cast<float>(pictures_));
    precision(k) = 1.0F / (spread * spread);
  }
  for (int k = window.of_pictures; k < components; ++k) {
    const float spread =
        (k < window.of_pictures + 2 ? kFalls : kTint) * std::max(std::abs(prior(0)), 0.1F * window.scale[0]);
    precision(k) = 1.0F / (spread * spread);
  }
  VectorXf found = prior, weights(size);
  std::vector<float> misses(static_cast<std::size_t>(cells));
  MatrixXf weighted(size, components);
  for (int round = 0; round < kRounds; ++round) {
    const VectorXf off = now - basis * found;
    std::vector<float> sorted;
    for (Eigen::Index i = 0; i < cells; ++i) {
      misses[static_cast<std::size_t>(i)] = std::sqrt(weight(i) * off.segment<3>(3 * i).squaredNorm());
      if (weight(i) > 0.0F) sorted.push_back(misses[static_cast<std::size_t>(i)]);
    }
    if (sorted.empty()) break;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const float outlier = std::max(kOutlier, 1.5F * *middle);
    for (Eigen::Index i = 0; i < cells; ++i) {
      const float miss = misses[static_cast<std::size_t>(i)] / outlier;
      const float believed = 1.0F / (1.0F + miss * miss);
      weights.segment<3>(3 * i).setConstant(weight(i) * believed * believed);
    }
    weighted = basis.array().colwise() * weights.array();
    MatrixXf normal = basis.transpose() * weighted;
    normal.diagonal() += precision;
    found = normal.ldlt().solve(weighted.transpose() * now + precision.cwiseProduct(prior));
  }
  return {found.data(), found.data() + components};
}

void LightMix::explain(const Image<glm::vec3>& light, const Image<float>& sigma) {
  now_ = expected_ = light;
  weight_ = miss2_ = Image<float>(light.width(), light.height());
  best_ = Image<std::uint16_t>(light.width(), light.height(), 0);
  for (std::size_t i = 0; i < now_.elements().size(); ++i) {
    now_.elements()[i] *= steps_.elements()[i];
    const float one = sigma.elements()[i];
    weight_.elements()[i] = one > 0.0F ? 1.0F / (one * one) : 0.0F;
    miss2_.elements()[i] = 1e30F;
  }
  // At first, the exposure: by how much the whole differs from what is remembered in the mean.
  std::vector<float> ratios;
  for (std::size_t i = 0; i < now_.elements().size(); i += 2) {
    const auto& first = windows_[0];
    const float usual = first.basis[3 * i + 1];
    if (weight_.elements()[i] > 0.0F && std::abs(usual) > 1e-6F) ratios.push_back(now_.elements()[i].g / usual);
  }
  std::vector<float> shares(pictures_, 0.0F);
  if (!ratios.empty()) {
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    for (std::size_t i = 0; i < pictures_; ++i) shares[i] = *middle * windows_[0].made_of[i];
  }
  for (std::size_t w = 0; w < windows_.size(); ++w) {
    Window& window = windows_[w];
    const std::vector<float> found = fit(window, shares);
    window.shares.assign(pictures_, 0.0F);
    for (int k = 0; k < window.of_pictures; ++k)
      for (std::size_t i = 0; i < pictures_; ++i)
        window.shares[i] +=
            found[static_cast<std::size_t>(k)] * window.made_of[static_cast<std::size_t>(k) * pictures_ + i];
    if (w == 0) {
      shares = window.shares;
      continue;
    }
    const int components = window.of_pictures + window.more;
    const std::size_t size = 3U * static_cast<std::size_t>(window.columns) * static_cast<std::size_t>(window.rows);
    for (int y = 0; y < window.rows; ++y)
      for (int x = 0; x < window.columns; ++x) {
        glm::vec3 steps{0};
        const auto i = 3U * static_cast<std::size_t>(y * window.columns + x);
        for (int k = 0; k < components; ++k) {
          const float* of = &window.basis[static_cast<std::size_t>(k) * size + i];
          steps += found[static_cast<std::size_t>(k)] * glm::vec3{of[0], of[1], of[2]};
        }
        const glm::vec3 off = now_.at(window.column + x, window.row + y) - steps;
        float& least = miss2_.at(window.column + x, window.row + y);
        if (glm::dot(off, off) >= least) continue;
        least = glm::dot(off, off);
        best_.at(window.column + x, window.row + y) = static_cast<std::uint16_t>(w);
        expected_.at(window.column + x, window.row + y) =
            glm::max(steps, glm::vec3{0}) / steps_.at(window.column + x, window.row + y);
      }
  }
}

std::span<const float> LightMix::shares(int column, int row) const {
  return windows_[best_.at(column, row)].shares;
}

}  // namespace kasumi
