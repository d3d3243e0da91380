#include "calib/colour/sensitivity_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "base/statistics.hpp"
#include "calib/colour/daylight_response.hpp"
#include "calib/colour/non_negative.hpp"

namespace kasumi {
namespace {

using Covariance = Eigen::Matrix<double, kBands, kBands>;

// Smooth deviations: standard deviation relative to the mean curve, the floor of that as a share of its largest value,
// and their correlation length. Rough deviations only keep the prior's covariance invertible.
constexpr double kSmooth = 0.3, kFloor = 0.05, kAlike_nm = 20.0, kRough = 1e-3;
// The sky model's own error, a floor however well a picture fits: ln ratio.
constexpr double kLeastScatter = 5e-4;

struct Prior {
  std::array<BandCurve, 3> mean;
  std::array<Covariance, 3> covariance;
};

Prior prior_of(std::span<const SpectralSensitivity> cameras) {
  Prior prior;
  for (std::size_t c = 0; c < 3; ++c) {
    auto& mean = prior.mean[c];
    mean.setZero();
    for (const auto& camera : cameras)
      mean += curve_of(camera, static_cast<int>(c)) / static_cast<double>(cameras.size());
    Covariance covariance = Covariance::Zero();
    for (const auto& camera : cameras) {
      const BandCurve deviation = curve_of(camera, static_cast<int>(c)) - mean;
      covariance += deviation * deviation.transpose() / static_cast<double>(cameras.size() - 1);
    }
    const double peak = mean.maxCoeff();
    for (int i = 0; i < kBands; ++i)
      for (int j = 0; j < kBands; ++j) {
        const double apart = (band_nm(i) - band_nm(j)) / kAlike_nm;
        covariance(i, j) +=
            kSmooth * kSmooth * (mean[i] + kFloor * peak) * (mean[j] + kFloor * peak) * std::exp(-0.5 * apart * apart);
      }
    covariance.diagonal().array() += kRough * kRough * peak * peak;
    prior.covariance[c] = covariance;
  }
  return prior;
}

// Robust weights of the colours, by the residuals of both ratios; and the scatter of the inliers.
struct Agreement {
  std::vector<double> weight;
  double scatter = 0.0;
};

Agreement agreement_of(const std::vector<glm::dvec2>& left) {
  std::vector<double> sizes;
  for (const auto& off : left) sizes.push_back(std::hypot(off.x, off.y));
  Agreement agreement{{}, std::max(kLeastScatter, median(sizes) / kMedianLengthOverSigma)};
  for (const double size : sizes) agreement.weight.push_back(tukey_weight(size / (kTukeyReach * agreement.scatter)));
  return agreement;
}

// Gains are offsets of the log ratios: their robust centre.
struct Centred {
  glm::dvec2 offset{};
  std::vector<glm::dvec2> left;
  Agreement agreement;
};

Centred centred(std::span<const DaylightColour> colours, const DaylightResponse& daylight) {
  Centred result;
  std::array<std::vector<double>, 2> raw;
  for (const auto& colour : colours) {
    const auto off = colour.log_ratio - log_ratios(daylight, colour.spectrum);
    raw[0].push_back(off.x);
    raw[1].push_back(off.y);
  }
  result.offset = {median(raw[0]), median(raw[1])};
  result.left.resize(colours.size());
  for (int round = 0; round < 10; ++round) {
    for (std::size_t i = 0; i < colours.size(); ++i) result.left[i] = glm::dvec2{raw[0][i], raw[1][i]} - result.offset;
    result.agreement = agreement_of(result.left);
    glm::dvec2 sum{0.0};
    double weights = 0.0;
    for (std::size_t i = 0; i < colours.size(); ++i) {
      sum += result.agreement.weight[i] * result.left[i];
      weights += result.agreement.weight[i];
    }
    result.offset += sum / std::max(weights, 1e-9);
  }
  return result;
}

// The data, linearised at the current estimate, in 8 numbers: DaylightResponse and the two offsets.
struct Information {
  Eigen::Matrix<double, 8, 8> matrix = Eigen::Matrix<double, 8, 8>::Zero();
  Eigen::Matrix<double, 8, 1> pull = Eigen::Matrix<double, 8, 1>::Zero();
};

Information information_of(std::span<const DaylightColour> colours, const DaylightResponse& daylight,
                           const Centred& at) {
  int pictures = 0;
  for (const auto& colour : colours) pictures = std::max(pictures, colour.picture + 1);
  const double counts = std::min(1.0, kIndependentParts * pictures / static_cast<double>(colours.size()));
  const double variance = at.agreement.scatter * at.agreement.scatter / counts;
  Information information;
  for (std::size_t i = 0; i < colours.size(); ++i) {
    const auto& spectrum = colours[i].spectrum;
    Eigen::Matrix<double, 2, 8> slope = Eigen::Matrix<double, 2, 8>::Zero();
    for (int k = 0; k < 2; ++k) {
      for (const auto& [channel, sign] : {std::pair{kAgainstGreen[static_cast<std::size_t>(k)], 1.0}, {1, -1.0}}) {
        const double response = std::exp(log_response(daylight, channel, spectrum));
        slope(k, 2 * channel) = sign * spectrum.m1 / response;
        slope(k, 2 * channel + 1) = sign * spectrum.m2 / response;
      }
      slope(k, 6 + k) = 1.0;
    }
    const double weight = at.agreement.weight[i] / variance;
    information.matrix += weight * slope.transpose() * slope;
    information.pull += weight * slope.transpose() * Eigen::Vector2d(at.left[i].x, at.left[i].y);
  }
  return information;
}

constexpr int kUnknowns = 3 * kBands + 2;

// Rows: derivatives of DaylightResponse and the offsets by the unknowns.
Eigen::Matrix<double, 8, kUnknowns> slopes_of(const std::array<BandCurve, 3>& curves,
                                              const DaylightResponse& daylight) {
  Eigen::Matrix<double, 8, kUnknowns> slopes = Eigen::Matrix<double, 8, kUnknowns>::Zero();
  for (int c = 0; c < 3; ++c) {
    const BandCurve s0 = daylight_sums().col(0);
    const double base = s0.dot(curves[static_cast<std::size_t>(c)]);
    for (int k = 0; k < 2; ++k)
      slopes.block<1, kBands>(2 * c + k, c * kBands) =
          (daylight_sums().col(k + 1) - daylight[2 * c + k] * s0).transpose() / base;
  }
  slopes(6, 3 * kBands) = slopes(7, 3 * kBands + 1) = 1.0;
  return slopes;
}

// How much the sky adds to the prior's knowledge of the six numbers. The offsets are marginalised, the rest is measured
// in the prior's standard deviations.
void judge(const Information& information, const Eigen::Matrix<double, 8, kUnknowns>& slopes, const Prior& prior,
           SensitivityFit& fit) {
  Eigen::Matrix<double, 6, 6> before = Eigen::Matrix<double, 6, 6>::Zero();
  for (int c = 0; c < 3; ++c) {
    const auto of = slopes.block<2, kBands>(2 * c, c * kBands);
    before.block<2, 2>(2 * c, 2 * c) = of * prior.covariance[static_cast<std::size_t>(c)] * of.transpose();
  }
  const auto& all = information.matrix;
  const Eigen::Matrix<double, 6, 6> reduced = all.topLeftCorner<6, 6>() - all.topRightCorner<6, 2>() *
                                                                              all.bottomRightCorner<2, 2>().inverse() *
                                                                              all.bottomLeftCorner<2, 6>();
  const Eigen::Matrix<double, 6, 6> root = before.llt().matrixL();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(root.transpose() * reduced * root);
  const auto& values = solver.eigenvalues();
  fit.determined = static_cast<int>((values.array() > 1.0).count());
  fit.condition = std::sqrt(values[5] / std::max(values[0], 1e-12 * values[5]));
}

std::array<ChannelPlace, 3> places_of(const std::array<BandCurve, 3>& curves, const Eigen::MatrixXd& covariance,
                                      const Prior& prior) {
  std::array<ChannelPlace, 3> places;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto mean_of = [](const BandCurve& curve) {
      double sum = 0.0;
      for (int i = 0; i < kBands; ++i) sum += curve[i] * band_nm(i);
      return sum / curve.sum();
    };
    const auto sigma_of = [](const Covariance& of, double mean) {
      BandCurve lever;
      for (int i = 0; i < kBands; ++i) lever[i] = (band_nm(i) - mean) / kBands;
      return std::sqrt(std::max(0.0, lever.dot(of * lever)));
    };
    const auto at = static_cast<Eigen::Index>(c) * kBands;
    places[c].mean_nm = mean_of(curves[c]);
    places[c].sigma_nm = sigma_of(covariance.block<kBands, kBands>(at, at), places[c].mean_nm);
    places[c].before_sigma_nm = sigma_of(prior.covariance[c], mean_of(prior.mean[c]));
  }
  return places;
}

// All channels respond alike to a flat spectrum; the largest value is 1.
SpectralSensitivity sensitivity_of(const std::array<BandCurve, 3>& curves) {
  SpectralSensitivity sensitivity{"estimated from the sky", kFirstVisible_nm, kBandStep_nm, {}};
  const double largest = std::max({curves[0].maxCoeff(), curves[1].maxCoeff(), curves[2].maxCoeff()});
  for (int i = 0; i < kBands; ++i)
    sensitivity.samples.push_back(glm::dvec3{curves[0][i], curves[1][i], curves[2][i]} / largest);
  return sensitivity;
}

}  // namespace

ColourResiduals explain(std::span<const DaylightColour> colours, const SpectralSensitivity& sensitivity) {
  const auto at = centred(colours, daylight_response_of(curves_of(sensitivity)));
  ColourResiduals result;
  result.left = at.left;
  double sum = 0.0, weights = 0.0;
  for (std::size_t i = 0; i < at.left.size(); ++i) {
    const double weight = at.agreement.weight[i];
    result.used.push_back(weight > 0.0);
    sum += weight * (at.left[i].x * at.left[i].x + at.left[i].y * at.left[i].y);
    weights += 2.0 * weight;
  }
  result.rms = weights > 0.0 ? std::sqrt(sum / weights) : 0.0;
  glm::dvec3 of_s0{0.0};
  for (double nm = kFirstVisible_nm; nm <= kLastVisible_nm; nm += 1.0)
    of_s0 += daylight_components(nm).x * sensitivity.at(nm);
  result.white_balance = {std::exp(at.offset.x) * of_s0.y / of_s0.x, 1.0, std::exp(at.offset.y) * of_s0.y / of_s0.z};
  return result;
}

Result<SensitivityFit> fit_sensitivity(std::span<const DaylightColour> colours,
                                       std::span<const SpectralSensitivity> cameras) {
  Problems problems;
  if (cameras.size() < 2) problems.add("{} measured cameras: expected at least 2, better 4 and more", cameras.size());
  if (colours.size() < 8) problems.add("{} parts of a clear sky: expected at least 8", colours.size());
  for (const auto& camera : cameras)
    if (!separates_daylight(camera))
      problems.add("{}: expected a camera whose channels distinguish the colours of the sky", camera.name);
  if (!problems.empty()) return fail(problems.fault());

  const auto prior = prior_of(cameras);
  Eigen::MatrixXd known = Eigen::MatrixXd::Zero(kUnknowns, kUnknowns);
  Eigen::VectorXd pull = Eigen::VectorXd::Zero(kUnknowns);
  constexpr double kMeanIsOne = 1e6;  // curves are relative: their scale is fixed
  for (int c = 0; c < 3; ++c) {
    const auto& covariance = prior.covariance[static_cast<std::size_t>(c)];
    const Eigen::LLT<Covariance> root(covariance);
    known.block<kBands, kBands>(c * kBands, c * kBands) =
        root.solve(Covariance::Identity()) + Covariance::Constant(kMeanIsOne / kBands);
    pull.segment<kBands>(c * kBands) =
        root.solve(prior.mean[static_cast<std::size_t>(c)]) + BandCurve::Constant(kMeanIsOne);
  }

  auto curves = prior.mean;
  Centred at;
  Information information;
  Eigen::Matrix<double, 8, kUnknowns> slopes;
  Eigen::MatrixXd matrix;
  NonNegative solved;
  constexpr int kRounds = 30;
  for (int round = 0; round < kRounds; ++round) {
    const auto daylight = daylight_response_of(curves);
    at = centred(colours, daylight);
    information = information_of(colours, daylight, at);
    slopes = slopes_of(curves, daylight);
    Eigen::VectorXd now(kUnknowns);
    now << curves[0], curves[1], curves[2], 0.0, 0.0;
    matrix = known + slopes.transpose() * information.matrix * slopes;
    const Eigen::VectorXd wanted = pull + slopes.transpose() * (information.pull + information.matrix * (slopes * now));
    solved = least_non_negative(matrix, wanted, 3 * kBands);
    double moved = 0.0;
    for (int c = 0; c < 3; ++c) {
      BandCurve next = solved.x.segment<kBands>(c * kBands);
      next *= kBands / next.sum();
      auto& curve = curves[static_cast<std::size_t>(c)];
      moved = std::max(moved, (next - curve).cwiseAbs().maxCoeff() / curve.maxCoeff());
      curve = next;
    }
    if (moved < 1e-6) break;
  }

  SensitivityFit fit;
  fit.sensitivity = sensitivity_of(curves);
  fit.residuals = explain(colours, fit.sensitivity);
  judge(information, slopes, prior, fit);
  const Eigen::MatrixXd covariance = covariance_of(matrix, solved);
  fit.places = places_of(curves, covariance, prior);
  fit.gain_sigma = {std::sqrt(covariance(3 * kBands, 3 * kBands)),
                    std::sqrt(covariance(3 * kBands + 1, 3 * kBands + 1))};
  return fit;
}

std::vector<DaylightColour> seen_by(const SpectralSensitivity& sensitivity, std::span<const DaylightColour> colours,
                                    std::span<const glm::dvec2> left) {
  const auto daylight = daylight_response_of(curves_of(sensitivity));
  std::vector<DaylightColour> result(colours.begin(), colours.end());
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i].log_ratio = log_ratios(daylight, result[i].spectrum) + (i < left.size() ? left[i] : glm::dvec2{0.0});
  return result;
}

std::string csv_of(const SpectralSensitivity& sensitivity, const std::string& comment) {
  std::string text;
  std::istringstream lines(comment);
  for (std::string line; std::getline(lines, line);) text += "# " + line + "\n";
  text += "wavelength_nm,red,green,blue\n";
  for (std::size_t i = 0; i < sensitivity.samples.size(); ++i) {
    const auto& sample = sensitivity.samples[i];
    text +=
        fmt::format("{:.6g},{:.6g},{:.6g},{:.6g}\n",
                    sensitivity.first_nm + sensitivity.step_nm * static_cast<double>(i), sample.r, sample.g, sample.b);
  }
  return text;
}

}  // namespace kasumi
