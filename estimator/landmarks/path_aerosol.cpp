#include "estimator/landmarks/path_aerosol.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "base/square.hpp"

namespace kasumi {
namespace {

using ColourVector = Eigen::VectorXd;
using ColourMatrix = Eigen::MatrixXd;

// The likelihood is computed on a grid of ln(extinction) and exponent, then on a finer one where it is high.
constexpr double kClearestAerosol_per_m = 1e-6, kThickestAerosol_per_m = 0.3;
constexpr double kLowestExponent = -0.5, kHighestExponent = 2.5;  // as may be given
constexpr int kCoarseAmounts = 64, kCoarseExponents = 13, kFineAmounts = 31, kFineExponents = 13;
constexpr double kFineRise = 18.0;      // of -2 ln likelihood: 4 sigma and a little
constexpr double kBoundRise = 4.0;      // 2 sigma
constexpr double kNodesExponent = 1.3;  // for which the nodes are made; others cost some 1e-3
// How far beyond the end of the exponent's range is looked, from how near to it: in steps of .25.
constexpr int kBeyond = 6;
constexpr double kAtTheEnd = 0.3;
constexpr double kUsualExponent = 1.3, kUsualExponentSigma = 0.5;
const glm::dvec3 kGrey{0.21, 0.72, 0.07};
// What the sun may add to the land of a picture, in units of the horizon's light in green; all are equally likely.
constexpr std::array<double, 4> kInTheSun{0.0, 0.12, 0.24, 0.36};

struct Steps {
  double first, last;
  int count;
  double at(int k) const { return first + (last - first) * k / (count - 1); }
};

struct Cell {
  double log_per_m, exponent, minus_two_log;
};

glm::dvec3 unsaturated(const glm::dvec3& contrast, double chroma) {
  const double grey = glm::dot(contrast, kGrey);
  return grey + (contrast - grey) / chroma;
}

// The symmetric root of an information matrix, and what it makes of the constants that it is of.
std::pair<ColourMatrix, ColourVector> rooted(const LearntConstants& learnt, Eigen::Index size) {
  const Eigen::SelfAdjointEigenSolver<ColourMatrix> parts(
      Eigen::Map<const ColourMatrix>(learnt.information.data(), size, size));
  constexpr double kNothing = 1e-12;  // of the greatest: rounding
  const double least = kNothing * std::max(parts.eigenvalues().maxCoeff(), 0.0);
  const ColourVector root = parts.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  ColourVector inverse = ColourVector::Zero(size);
  for (Eigen::Index k = 0; k < size; ++k)
    if (parts.eigenvalues()[k] > least) inverse[k] = 1.0 / root[k];
  const auto& axes = parts.eigenvectors();
  const ColourVector along = axes.transpose() * Eigen::Map<const ColourVector>(learnt.pull.data(), size);
  return {axes * root.asDiagonal() * axes.transpose(), axes * inverse.cwiseProduct(along)};
}

}  // namespace

// The readings used, flattened.
struct LandmarkColours::Asked {
  std::vector<std::size_t> landmarks;
  ColourVector contrast, sigma, mean, lit, floor, floor_sigma, scatter;
  ColourVector sun;  // what the sun adds, over what it adds in green; 0 for what is known to be in the shade
  ColourMatrix known;
  double altitude_factor = 1.0;  // aerosol at sea level over that at the camera
};

// readings = haze * (contrast + change of its lighting) + noise; all normal.
struct LandmarkColours::Model {
  ColourVector haze, by_log_amount;  // and its derivative by ln(extinction)
  ColourMatrix noise;
};

LandmarkColours::LandmarkColours(const Camera& camera, const std::vector<ContrastLandmark>& landmarks,
                                 double altitude_m, const ContrastSpread& spread, const ColourSpread& colours)
    : altitude_m_(altitude_m), spread_(spread), colours_(colours) {
  const auto measure = spectral_measure(camera);
  glm::dvec3 haze{0};
  nodes_ = attenuation_nodes(measure, kNodesExponent);
  double nm = measure.first_nm;
  for (const auto& weight : measure.weight) haze += weight * std::pow(nm++, -kNodesExponent);
  wavelength_nm_ = glm::pow(haze, glm::dvec3(-1.0 / kNodesExponent));
  const std::size_t count = 3 * landmarks.size();
  before_.covariance.resize(count * count);
  for (const auto& landmark : landmarks) {
    paths_.push_back(optical_path(altitude_m, altitude_m + landmark.rise_m, landmark.distance_m));
    unsaid_.push_back(!landmark.against && !landmark.faces && !landmark.contrast_stated);
  }
  laws_ = laws_of(landmarks, altitude_m);
  // The surface's own light in each channel, or a difference of two, in units of the horizon's.
  const auto own = [&](std::size_t k) {
    const double contrast = landmarks[k / 3].contrast;
    return laws_[k / 3].before_sky ? std::max(0.02, 1.0 - contrast) * colours.dull[static_cast<int>(k % 3)] : contrast;
  };
  const auto scale = [&](std::size_t k) {
    return landmarks[k / 3].contrast_sigma * (laws_[k / 3].before_sky ? colours.dull[static_cast<int>(k % 3)] : 1.0);
  };
  for (std::size_t k = 0; k < count; ++k) {
    before_.mean.push_back(laws_[k / 3].before_sky ? 1.0 - own(k) : own(k));
    before_.floor.push_back(0.0);
    before_.floor_sigma.push_back(landmarks[k / 3].infinity_sigma);
    before_.scatter.push_back(1.0);
    for (std::size_t l = 0; l < count; ++l) {
      const double together = k / 3 == l / 3 ? 1.0 : spread.known_together;
      before_.covariance[k * count + l] = together * scale(k) * scale(l);
      // How much light there is and which colour it has are both unsure: the second moment of their product.
      if (k % 3 == l % 3)
        before_.covariance[k * count + l] +=
            together * square(colours.colour[static_cast<int>(k % 3)]) * (own(k) * own(l) + scale(k) * scale(l));
    }
  }
  belief_ = before_;
}

LandmarkColours::Asked LandmarkColours::asked(const std::vector<ContrastReading>& readings,
                                              std::span<const std::size_t> left_out) const {
  Asked asked;
  for (std::size_t i = 0; i < readings.size() && i < paths_.size(); ++i)
    if (readings[i].usable && std::ranges::find(left_out, i) == left_out.end()) asked.landmarks.push_back(i);
  const auto count = static_cast<Eigen::Index>(3 * asked.landmarks.size());
  const auto all = belief_.mean.size();
  asked.contrast = asked.sigma = asked.mean = asked.lit = asked.floor = asked.floor_sigma = asked.scatter = asked.sun =
      ColourVector(count);
  asked.known = ColourMatrix(count, count);
  asked.altitude_factor = std::exp(altitude_m_ / kMieScaleHeight_m);
  const auto at = [&](Eigen::Index k) {
    return 3 * asked.landmarks[static_cast<std::size_t>(k / 3)] + static_cast<std::size_t>(k % 3);
  };
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto from = at(k);
    const auto& reading = readings[from / 3];
    const auto c = static_cast<int>(from % 3);
    asked.contrast[k] = unsaturated(reading.contrast, chroma_)[c];
    asked.sigma[k] =
        reading.sigma[c] * (reading.lit ? 0.0 : 1.0) / std::min(1.0, chroma_) + (reading.lit ? kLitBy : 0.0);
    asked.mean[k] = belief_.mean[from];
    asked.floor[k] = belief_.floor[from];
    asked.floor_sigma[k] = belief_.floor_sigma[from];
    asked.scatter[k] = belief_.scatter[from];
    asked.sun[k] = unsaid_[from / 3] ? colours_.sunlight[c] : 0.0;
    // Against the sky a surface's light varies in units of the sky's; between two surfaces their difference varies.
    asked.lit[k] = laws_[from / 3].before_sky ? std::max(0.02, 1.0 - belief_.mean[from]) : std::abs(belief_.mean[from]);
    for (Eigen::Index l = 0; l < count; ++l) asked.known(k, l) = belief_.covariance[from * all + at(l)];
  }
  return asked;
}

LandmarkColours::Model LandmarkColours::model_under(double per_m, double angstrom_exponent, const Asked& asked) const {
  const auto count = asked.contrast.size();
  Model model{ColourVector(count), ColourVector(count), ColourMatrix(count, count)};
  const Aerosol aerosol{per_m * asked.altitude_factor, angstrom_exponent, AerosolKind::continental};
  std::array<glm::dvec3, kAttenuationNodes> molecules{}, haze{};
  for (std::size_t n = 0; n < kAttenuationNodes; ++n)
    for (int c = 0; c < 3; ++c) {
      const double nm = nodes_.wavelength_nm[n][c];
      molecules[n][c] = rayleigh_per_m(ScatteringModel::aerosol, nm);
      haze[n][c] = optical_depth(aerosol, nm);
    }
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto& path = paths_[asked.landmarks[static_cast<std::size_t>(k / 3)]];
    const auto c = static_cast<int>(k % 3);
    model.haze[k] = model.by_log_amount[k] = 0.0;
    for (std::size_t n = 0; n < kAttenuationNodes; ++n) {
      const double depth = haze[n][c] * path.mie_m;
      const double left = nodes_.weight[n][c] * std::exp(-molecules[n][c] * path.rayleigh_m - depth);
      model.haze[k] += left;
      model.by_log_amount[k] -= depth * left;
    }
  }
  const ColourVector lit = model.haze.cwiseProduct(asked.lit);
  const ColourVector patchy = spread_.patchy * model.by_log_amount.cwiseProduct(asked.mean - asked.floor);
  for (Eigen::Index k = 0; k < count; ++k)
    for (Eigen::Index l = 0; l < count; ++l) {
      const bool same_channel = k % 3 == l % 3, same_landmark = k / 3 == l / 3;
      double noise =
          spread_.lit_together * spread_.lit_together * lit[k] * lit[l] * (same_channel ? 1.0 : colours_.lit);
      if (same_landmark) {
        const double scatter = asked.scatter[k] * asked.scatter[l];
        noise += scatter * spread_.lit_each * spread_.lit_each * lit[k] * lit[l] * (same_channel ? 1.0 : colours_.lit);
        noise += scatter * patchy[k] * patchy[l];
        noise += scatter * asked.sigma[k] * asked.sigma[l] * (same_channel ? 1.0 : colours_.read);
        noise += asked.floor_sigma[k] * asked.floor_sigma[l] * (1.0 - model.haze[k]) * (1.0 - model.haze[l]) *
                 (same_channel ? 1.0 : colours_.airlight_together);
      }
      const auto one = asked.landmarks[static_cast<std::size_t>(k / 3)];
      const auto other = asked.landmarks[static_cast<std::size_t>(l / 3)];
      if (laws_[one].before_sky && laws_[other].before_sky)
        noise += (1.0 - model.haze[k]) * (1.0 - model.haze[l]) *
                 (square(spread_.airlight) * (same_channel ? 1.0 : colours_.airlight_together) +
                  (same_channel && unsaid_[one] && unsaid_[other] ? square(colours_.airlight_colour) : 0.0));
      model.noise(k, l) = noise;
    }
  return model;
}

double LandmarkColours::minus_two_log(double per_m, double angstrom_exponent, const Asked& asked) const {
  const auto model = model_under(per_m, angstrom_exponent, asked);
  const ColourMatrix all = model.haze.asDiagonal() * asked.known * model.haze.asDiagonal() + model.noise;
  const ColourVector residual = asked.contrast - asked.floor - model.haze.cwiseProduct(asked.mean - asked.floor);
  const ColourVector sun = model.haze.cwiseProduct(asked.sun);
  const auto levels = asked.sun.isZero() ? std::size_t{1} : kInTheSun.size();
  std::array<double, kInTheSun.size()> rises{};
  for (std::size_t level = 0; level < levels; ++level) {
    ColourMatrix lit = all;
    const ColourVector by = kInTheSun[level] * sun, each = colours_.sun_each * by;
    for (Eigen::Index k = 0; k < by.size(); ++k)
      for (Eigen::Index l = k - k % 3; l <= k; ++l) lit(k, l) += each[k] * each[l] * (k == l ? 1.0 : colours_.sun);
    const Eigen::LLT<ColourMatrix> factor(lit);
    rises[level] =
        2.0 * factor.matrixLLT().diagonal().array().log().sum() + factor.matrixL().solve(residual + by).squaredNorm();
  }
  const double least = *std::min_element(rises.begin(), rises.begin() + static_cast<std::ptrdiff_t>(levels));
  double likelihood = 0.0;
  for (std::size_t level = 0; level < levels; ++level) likelihood += std::exp(-0.5 * (rises[level] - least));
  return least - 2.0 * std::log(likelihood);
}

PathAerosol LandmarkColours::estimate(const std::vector<ContrastReading>& readings,
                                      std::span<const std::size_t> left_out,
                                      const std::optional<Within>& within) const {
  PathAerosol found;
  const auto asked = this->asked(readings, left_out);
  found.landmarks = static_cast<int>(asked.landmarks.size());
  if (asked.landmarks.empty()) {
    found.reason = readings.empty() ? "no landmarks" : "no landmark can be used: " + readings.front().reason;
    return found;
  }
  const auto look = [&](const Steps& amounts, const Steps& exponents) {
    std::vector<Cell> cells;
    for (int k = 0; k < amounts.count; ++k)
      for (int l = 0; l < exponents.count; ++l) {
        const double log_per_m = amounts.at(k), exponent = exponents.at(l);
        cells.push_back({log_per_m, exponent, minus_two_log(std::exp(log_per_m), exponent, asked)});
      }
    return cells;
  };
  const auto best_of = [](const std::vector<Cell>& cells) {
    return *std::ranges::min_element(cells, {}, &Cell::minus_two_log);
  };
  const Steps all{std::log(kClearestAerosol_per_m), std::log(kThickestAerosol_per_m), kCoarseAmounts};
  const Steps exponents{kLowestExponent, kHighestExponent, kCoarseExponents};
  Steps likely = all;
  if (within) {
    likely.first = std::clamp(std::log(std::max(within->lowest_per_m, kClearestAerosol_per_m)), all.first, all.last);
    likely.last = std::clamp(std::log(std::max(within->highest_per_m, kClearestAerosol_per_m)), likely.first, all.last);
    const double step = (all.last - all.first) / (all.count - 1);
    likely.count = std::max(2, 1 + static_cast<int>(std::ceil((likely.last - likely.first) / step)));
  }
  const auto coarse = look(likely, exponents);
  const double low_enough = best_of(coarse).minus_two_log + kFineRise;
  const double amount_step = all.at(1) - all.first, exponent_step = exponents.at(1) - exponents.first;
  Steps near{all.last, all.first, kFineAmounts}, bent{exponents.last, exponents.first, kFineExponents};
  for (const auto& cell : coarse) {
    if (cell.minus_two_log > low_enough) continue;
    near.first = std::min(near.first, cell.log_per_m - amount_step);
    near.last = std::max(near.last, cell.log_per_m + amount_step);
    bent.first = std::min(bent.first, cell.exponent - exponent_step);
    bent.last = std::max(bent.last, cell.exponent + exponent_step);
  }
  near.first = std::max(near.first, all.first);
  near.last = std::min(near.last, all.last);
  bent.first = std::max(bent.first, exponents.first);
  bent.last = std::min(bent.last, exponents.last);
  const auto fine = look(near, bent);
  const double best = best_of(fine).minus_two_log;

  // Moments under an even belief in extinction and exponent.
  double weights = 0.0, amount = 0.0, exponent = 0.0, aa = 0.0, ae = 0.0, ee = 0.0;
  double lowest = std::numeric_limits<double>::infinity(), highest = 0.0;
  for (const auto& cell : fine) {
    const double per_m = std::exp(cell.log_per_m);
    const double weight = per_m * std::exp(-0.5 * (cell.minus_two_log - best));
    weights += weight;
    amount += weight * per_m;
    exponent += weight * cell.exponent;
    aa += weight * per_m * per_m;
    ae += weight * per_m * cell.exponent;
    ee += weight * cell.exponent * cell.exponent;
    if (cell.minus_two_log > best + kBoundRise) continue;
    lowest = std::min(lowest, per_m);
    highest = std::max(highest, per_m);
  }
  found.per_m = amount / weights;
  found.angstrom_exponent = exponent / weights;
  found.covariance = {aa / weights - found.per_m * found.per_m, ae / weights - found.per_m * found.angstrom_exponent,
                      ee / weights - found.angstrom_exponent * found.angstrom_exponent};
  found.lowest_per_m = lowest;
  found.highest_per_m = highest;
  const double margin = 1.0 + 0.5 * amount_step;
  const bool below = lowest > margin * kClearestAerosol_per_m, above = highest * margin < kThickestAerosol_per_m;
  found.kind = below ? (above ? ExtinctionKind::value : ExtinctionKind::at_least)
                     : (above ? ExtinctionKind::at_most : ExtinctionKind::nothing);
  if (found.kind == ExtinctionKind::at_most) found.reason = "so little aerosol that the landmarks do not show it";
  if (found.kind == ExtinctionKind::at_least) found.reason = "so much aerosol that the landmarks have gone";
  if (found.kind == ExtinctionKind::nothing) found.reason = "the landmarks' contrasts are consistent with any air";
  // Likelier by 2 sigma beyond either end.
  const auto likelier_beyond = [&](double end, double step) {
    if (std::abs(best_of(fine).exponent - end) > kAtTheEnd) return false;
    return best_of(look(near, {end + step, end + kBeyond * step, kBeyond})).minus_two_log < best - kBoundRise;
  };
  if (likelier_beyond(kLowestExponent, -exponent_step) || likelier_beyond(kHighestExponent, exponent_step)) {
    // No such aerosol is known: something else makes the colours, and the exponent is as unknown as before.
    found.exponent_told = false;
    found.angstrom_exponent = kUsualExponent;
    found.covariance.exponent = kUsualExponentSigma * kUsualExponentSigma;
    found.covariance.and_exponent = 0.0;
  }
  return found;
}

PathCovariance LandmarkColours::bound(const std::vector<ContrastReading>& readings, double per_m,
                                      double angstrom_exponent) const {
  const auto asked = this->asked(readings, {});
  const auto here = model_under(per_m, angstrom_exponent, asked);
  const Eigen::LLT<ColourMatrix> factor(here.haze.asDiagonal() * asked.known * here.haze.asDiagonal() + here.noise);
  constexpr double kStep = 1e-3;  // of a numerical derivative by the exponent
  Eigen::MatrixX2d by(asked.contrast.size(), 2);
  by.col(0) = here.by_log_amount.cwiseProduct(asked.mean - asked.floor) / per_m;
  by.col(1) = (model_under(per_m, angstrom_exponent + kStep, asked).haze -
               model_under(per_m, angstrom_exponent - kStep, asked).haze)
                  .cwiseProduct(asked.mean - asked.floor) /
              (2.0 * kStep);
  const Eigen::Matrix2d information = by.transpose() * factor.solve(by);
  const double determinant = information.determinant();
  return {information(1, 1) / determinant, -information(0, 1) / determinant, information(0, 0) / determinant};
}

PathReading LandmarkColours::reading_of(const PathAerosol& found) const {
  using Kind = PathReading::Channel::Kind;
  PathReading reading;
  const double exponent = found.angstrom_exponent, amount = found.kind == ExtinctionKind::at_most ? found.highest_per_m
                                                            : found.kind == ExtinctionKind::at_least
                                                                ? found.lowest_per_m
                                                                : found.per_m;
  const double relative = std::sqrt(found.covariance.per_m) / found.per_m;
  const auto kind_of = [](ExtinctionKind kind) {
    switch (kind) {
      case ExtinctionKind::value: return Kind::value;
      case ExtinctionKind::at_most: return Kind::at_most;
      case ExtinctionKind::at_least: return Kind::at_least;
      case ExtinctionKind::nothing: break;
    }
    return Kind::nothing;
  };
  // A straight line through ln(extinction) over ln(wavelength): what its slope is unsure of is each channel's own, the
  // rest of its height is common to all.
  std::array<double, 3> log_nm{};
  for (std::size_t c = 0; c < 3; ++c) log_nm[c] = std::log(wavelength_nm_[static_cast<int>(c)] / 550.0);
  const double middle = (log_nm[0] + log_nm[1] + log_nm[2]) / 3.0;
  double spread = 0.0;
  for (const double x : log_nm) spread += (x - middle) * (x - middle);
  const double own = std::sqrt(found.covariance.exponent * spread);
  const double height = relative * relative - 2.0 * middle * found.covariance.and_exponent / found.per_m +
                        middle * middle * found.covariance.exponent;
  const double shared = std::sqrt(std::max(0.0, height - own * own / 3.0));
  double aerosol = 0.0, all = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    auto& channel = reading.channels[c];
    channel.kind = kind_of(found.kind);
    channel.wavelength_nm = wavelength_nm_[static_cast<int>(c)];
    const double per_m = amount * std::exp(-exponent * log_nm[c]);
    channel.per_m = per_m + rayleigh_per_m(ScatteringModel::aerosol, channel.wavelength_nm, altitude_m_);
    channel.sigma_per_m = own * per_m;
    aerosol += per_m;
    all += channel.per_m;
  }
  reading.shared_sigma = shared * aerosol / all;
  return reading;
}

void LandmarkColours::believe(const std::array<LearntConstants, 3>& channels,
                              const std::array<std::vector<double>, 3>& scatter) {
  const auto landmarks = static_cast<Eigen::Index>(laws_.size()), half = 3 * landmarks;
  belief_ = before_;
  if (landmarks == 0 || channels[0].pull.empty()) return;
  const auto place = [](Eigen::Index k, std::size_t c) { return 3 * k + static_cast<Eigen::Index>(c); };

  // The channels' errors go together (ColourSpread::learnt_together): information is F R^-1 F', F the root of each
  // channel's own, R their correlation.
  ColourMatrix information = ColourMatrix::Zero(2 * half, 2 * half);
  ColourVector pull = ColourVector::Zero(2 * half);
  std::array<ColourMatrix, 3> roots;
  std::array<ColourVector, 3> whitened;
  for (std::size_t c = 0; c < 3; ++c) std::tie(roots[c], whitened[c]) = rooted(channels[c], 2 * landmarks);
  Eigen::Matrix3d together = Eigen::Matrix3d::Constant(colours_.learnt_together);
  together.diagonal().setOnes();
  const Eigen::Matrix3d apart = together.inverse();
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t d = 0; d < 3; ++d) {
      const double weight = apart(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(d));
      const ColourMatrix block = weight * roots[c] * roots[d];
      const ColourVector towards = weight * roots[c] * whitened[d];
      for (Eigen::Index k = 0; k < 2 * landmarks; ++k) {
        pull[place(k, c)] += towards[k];
        for (Eigen::Index l = 0; l < 2 * landmarks; ++l) information(place(k, c), place(l, d)) = block(k, l);
      }
    }
  // Of the true contrasts, from which the camera has made what was read.
  ColourMatrix seen = ColourMatrix::Zero(2 * half, 2 * half);
  for (Eigen::Index k = 0; k < 2 * landmarks; ++k)
    for (Eigen::Index c = 0; c < 3; ++c)
      for (Eigen::Index d = 0; d < 3; ++d)
        seen(3 * k + c, 3 * k + d) = (c == d ? chroma_ : 0.0) + (1.0 - chroma_) * kGrey[static_cast<int>(d)];
  information = (seen.transpose() * information * seen).eval();
  pull = (seen.transpose() * pull).eval();

  ColourMatrix known = ColourMatrix::Zero(2 * half, 2 * half);
  known.topLeftCorner(half, half) = Eigen::Map<const ColourMatrix>(belief_.covariance.data(), half, half);
  ColourVector mean = ColourVector::Zero(2 * half);
  mean.head(half) = Eigen::Map<const ColourVector>(belief_.mean.data(), half);
  for (Eigen::Index k = 0; k < half; ++k)
    for (Eigen::Index c = 0; c < 3; ++c) {
      const auto other = 3 * (k / 3) + c;
      const double sigma = std::max(kLeastFloorSigma, belief_.floor_sigma[static_cast<std::size_t>(k)]);
      known(half + k, half + other) = square(sigma) * (k == other ? 1.0 : colours_.airlight_together);
    }
  const ColourMatrix identity = ColourMatrix::Identity(2 * half, 2 * half);
  const ColourMatrix prior = known.llt().solve(identity);
  const Eigen::LLT<ColourMatrix> factor(prior + information);
  const ColourVector solved = factor.solve(prior * mean + pull);
  const ColourMatrix left = factor.solve(identity);
  for (Eigen::Index k = 0; k < half; ++k) {
    const auto at = static_cast<std::size_t>(k);
    belief_.mean[at] = std::min(kDarkest, solved[k]);
    belief_.floor[at] = solved[half + k];
    belief_.floor_sigma[at] = std::sqrt(left(half + k, half + k));
    belief_.scatter[at] = scatter[at % 3][at / 3];
    for (Eigen::Index l = 0; l < half; ++l)
      belief_.covariance[at * static_cast<std::size_t>(half) + static_cast<std::size_t>(l)] =
          0.5 * (left(k, l) + left(l, k)) + (k == l ? square(kLeastContrastSigma) : 0.0);
  }
}

}  // namespace kasumi
