#include "estimator/turbidity/clear_form.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <opencv2/core.hpp>

#include "base/statistics.hpp"
#include "base/units.hpp"

namespace kasumi {

namespace {

constexpr std::size_t kTerms = ClearForm::kTerms;  // short for the class's own

float sum_of(const ClearForm::Terms& terms, const ClearForm::Terms& factors) {
  float sum = 0.0f;
  for (std::size_t k = 0; k < kTerms; ++k) sum += terms[k] * factors[k];
  return sum;
}

constexpr std::size_t kLane = 4;  // of a vector; loops over so many become one
// Of cubic splines, four; and the class's own.
constexpr std::size_t kSpline = 4, kSlow = ClearForm::kSlow, kRadial = ClearForm::kRadial;

// A place without the zeros among its terms: around any distance from the sun four splines are not 0.
struct FormRow {
  std::size_t span = 0;  // the first of them
  std::array<float, kSpline> radial{};
  std::array<float, kSlow> slow{};
  float luminance = 0.0f, colour = 0.0f, weight = 0.0f;
};

FormRow row_of(const LookedAt& p) {
  FormRow row;
  while (row.span + kSpline < kRadial && p.terms[row.span] == 0.0f) ++row.span;
  std::copy_n(p.terms.begin() + static_cast<std::ptrdiff_t>(row.span), kSpline, row.radial.begin());
  std::copy_n(p.terms.begin() + kRadial, kSlow, row.slow.begin());
  row.luminance = p.luminance;
  row.colour = p.colour;
  row.weight = p.weight;
  return row;
}

float sum_of(const FormRow& row, const ClearForm::Terms& factors) {
  std::array<float, kLane> part{};
  for (std::size_t l = 0; l < kLane; ++l) part[l] = row.radial[l] * factors[row.span + l];
  for (std::size_t k = 0; k < kSlow; k += kLane)
    for (std::size_t l = 0; l < kLane; ++l) part[l] += row.slow[k + l] * factors[kRadial + k + l];
  return (part[0] + part[1]) + (part[2] + part[3]);
}

// Sums over some places of products of their terms, and of these with luminance and colour.
struct FormSums {
  std::array<float, kRadial * kSpline> radial{};    // of a spline and those from itself on
  std::array<float, kRadial * kSlow> mixed{};       // of a spline and the slow terms
  std::array<float, kSlow * kSlow> slow{};          // from the diagonal's lane on
  std::array<float, kTerms> luminance{}, colour{};  // of all terms
};

void add_row(FormSums& sums, const FormRow& row) {
  for (std::size_t i = 0; i < kSpline; ++i) {
    const float w = row.weight * row.radial[i];
    const std::size_t at = row.span + i;
    sums.luminance[at] += w * row.luminance;
    sums.colour[at] += w * row.colour;
    for (std::size_t j = i; j < kSpline; ++j) sums.radial[at * kSpline + j - i] += w * row.radial[j];
    float* mixed = sums.mixed.data() + at * kSlow;
    for (std::size_t j = 0; j < kSlow; ++j) mixed[j] += w * row.slow[j];
  }
  const float light = row.weight * row.luminance, colour = row.weight * row.colour;
  for (std::size_t j = 0; j < kSlow; ++j) sums.luminance[kRadial + j] += light * row.slow[j];
  for (std::size_t j = 0; j < kSlow; ++j) sums.colour[kRadial + j] += colour * row.slow[j];
  for (std::size_t i = 0; i < kSlow; ++i) {
    const float w = row.weight * row.slow[i];
    float* slow = sums.slow.data() + i * kSlow;
    for (std::size_t j = i / kLane * kLane; j < kSlow; j += kLane)
      for (std::size_t l = 0; l < kLane; ++l) slow[j + l] += w * row.slow[j + l];
  }
}

bool solve_form(const std::vector<FormRow>& places, ClearFormFit& sky) {
  constexpr double kStiffness = 1e-7;  // keeps factors finite where no place determines them
  constexpr std::size_t kBlock = 64;   // places: single precision adds so many without loss
  std::array<double, kTerms * kTerms> normal{};
  std::array<double, kTerms> y{}, c{};
  double all = 0.0;
  for (std::size_t from = 0; from < places.size(); from += kBlock) {
    FormSums sums;
    for (std::size_t k = from; k < std::min(from + kBlock, places.size()); ++k) {
      if (places[k].weight <= 0.0f) continue;
      all += static_cast<double>(places[k].weight);
      add_row(sums, places[k]);
    }
    for (std::size_t i = 0; i < kTerms; ++i) {
      y[i] += static_cast<double>(sums.luminance[i]);
      c[i] += static_cast<double>(sums.colour[i]);
    }
    for (std::size_t i = 0; i < kRadial; ++i) {
      for (std::size_t j = i; j < std::min(i + kSpline, kRadial); ++j)
        normal[i * kTerms + j] += static_cast<double>(sums.radial[i * kSpline + j - i]);
      for (std::size_t j = 0; j < kSlow; ++j)
        normal[i * kTerms + kRadial + j] += static_cast<double>(sums.mixed[i * kSlow + j]);
    }
    for (std::size_t i = 0; i < kSlow; ++i)
      for (std::size_t j = i; j < kSlow; ++j)
        normal[(kRadial + i) * kTerms + kRadial + j] += static_cast<double>(sums.slow[i * kSlow + j]);
  }
  if (all <= 4.0 * kTerms) return false;
  constexpr int n = kTerms;  // short for the matrices below
  cv::Mat1d a(n, n), b(n, 2), x;
  for (int i = 0; i < n; ++i) {
    const auto row = static_cast<std::size_t>(i);
    for (int j = i; j < n; ++j) a(i, j) = a(j, i) = normal[row * kTerms + static_cast<std::size_t>(j)];
    a(i, i) += kStiffness * all;
    b(i, 0) = y[row];
    b(i, 1) = c[row];
  }
  // Where no place determines it, in an overexposed aureole, the function of the distance is extrapolated.
  constexpr double kBending = 1e-4;
  constexpr std::array kSecondDifference{1.0, -2.0, 1.0};
  for (int k = 0; k + 2 < static_cast<int>(ClearForm::kRadial); ++k)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        a(k + i, k + j) += kBending * all * kSecondDifference[static_cast<std::size_t>(i)] *
                           kSecondDifference[static_cast<std::size_t>(j)];
  if (!cv::solve(a, b, x, cv::DECOMP_CHOLESKY)) return false;
  for (int k = 0; k < n; ++k) {
    sky.luminance[static_cast<std::size_t>(k)] = static_cast<float>(x(k, 0));
    sky.colour[static_cast<std::size_t>(k)] = static_cast<float>(x(k, 1));
  }
  return true;
}

}  // namespace

ClearForm::ClearForm(const SunDirection& sun) : sun_(sun) {
  const glm::vec2 level(sun.x, sun.y);
  const float length = glm::length(level);
  ahead_ = length > 1e-4f ? level / length : glm::vec2{0.0f, 1.0f};
}

ClearForm::Terms ClearForm::at(const glm::vec3& direction) const {
  Terms terms{};
  // Uniform cubic B-splines over ln(gamma + 3 deg): fine where the aureole is steep.
  constexpr double kOffset = 3.0 * kPi / 180.0, kFirst = 2.0 * kPi / 180.0, kSpans = kRadial - 3;
  static const double first = std::log(kOffset + kFirst), last = std::log(kOffset + kPi);
  const double gamma = std::acos(std::clamp(static_cast<double>(glm::dot(direction, sun_)), -1.0, 1.0));
  const double place = std::clamp((std::log(kOffset + gamma) - first) / (last - first), 0.0, 0.99999) * kSpans;
  const auto span = static_cast<std::size_t>(place);
  const auto t = static_cast<float>(place - static_cast<double>(span));
  const float u = 1.0f - t, t2 = t * t, t3 = t2 * t;
  terms[span] = u * u * u / 6.0f;
  terms[span + 1] = (3.0f * t3 - 6.0f * t2 + 4.0f) / 6.0f;
  terms[span + 2] = (-3.0f * t3 + 3.0f * t2 + 3.0f * t + 1.0f) / 6.0f;
  terms[span + 3] = t3 / 6.0f;
  const float x = glm::dot(glm::vec2(direction), ahead_), y = direction.x * ahead_.y - direction.y * ahead_.x,
              z = direction.z, low = 0.2f / (z + 0.1f);
  const auto near = static_cast<float>(std::exp(-4.0 * gamma));  // the lower, the more air before the aureole
  const std::array<float, kSlow> slow{
      low,       low * low, z,     z * z, x,       x * z,      x * low,          x * x,
      x * x * x, y,         y * z, x * y, y * low, near * low, near * low * low, near * z};
  std::ranges::copy(slow, terms.begin() + kRadial);
  return terms;
}

float ClearFormFit::luminance_at(const ClearForm::Terms& terms) const {
  return sum_of(terms, luminance);
}
float ClearFormFit::colour_at(const ClearForm::Terms& terms) const {
  return sum_of(terms, colour);
}

std::optional<ClearFormFit> fit_clear_form(const std::vector<LookedAt>& places, const ClearFormWindow& windows) {
  constexpr float kPerColour = 1.5f;  // of ln R/B: colour separates better than light
  ClearFormFit sky;
  std::vector<FormRow> rows;
  rows.reserve(places.size());
  for (const LookedAt& p : places) rows.push_back(row_of(p));
  float window = windows.widest;
  for (int round = 0; round < windows.rounds; ++round) {
    if (!solve_form(rows, sky)) return std::nullopt;
    for (FormRow& p : rows) {
      const float dy = (p.luminance - sum_of(p, sky.luminance)) / window;
      const float dc = kPerColour * (p.colour - sum_of(p, sky.colour)) / window;
      const float u = std::max(0.0f, 1.0f - dy * dy - dc * dc);
      p.weight = u * u;
    }
    window = std::max(windows.narrowest, 0.75f * window);
  }
  std::vector<float> dy, dc;
  for (const FormRow& p : rows) {
    if (p.weight <= 0.0f) continue;
    dy.push_back(std::abs(p.luminance - sum_of(p, sky.luminance)));
    dc.push_back(std::abs(p.colour - sum_of(p, sky.colour)));
  }
  if (dy.size() <= 4 * kTerms) return std::nullopt;
  sky.luminance_scatter = static_cast<float>(kSigmaOverMedianSize) * median_in_place(dy);
  sky.colour_scatter = static_cast<float>(kSigmaOverMedianSize) * median_in_place(dc);
  return sky;
}

}  // namespace kasumi
