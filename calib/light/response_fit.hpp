// A camera's response curve from pictures of one view taken with different exposures.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "base/image.hpp"
#include "base/result.hpp"
#include "base/saturation.hpp"
#include "calib/light/radiometry.hpp"

namespace kasumi {

// Some pixels of the stack: their value in each exposure, 0..1, black level removed. Exposures in any order.
struct StackSamples {
  std::size_t exposures = 0;
  std::size_t pixels = 0;
  double quantum = 1.0 / 255.0;               // smallest step of a value
  std::array<std::vector<double>, 3> values;  // R, G, B; pixel after pixel
  double at(int channel, std::size_t pixel, std::size_t exposure) const {
    return values[static_cast<std::size_t>(channel)][pixel * exposures + exposure];
  }
};

// At most `count` pixels, spread evenly over all brightnesses, none where the mask is 0. `black`: encoded level without
// light, of each channel. The pictures are of one size, at least 2.
StackSamples sample_stack(const std::vector<Image<glm::vec3>>& pictures, double quantum, const glm::dvec3& black,
                          const Image<std::uint8_t>& mask, std::size_t count);

// What is known of the exposures: natural logarithms of their times, and the standard deviation of each (0: exact).
// Unless `known`, they are estimated from the pictures alone, and `log_s` is only the initial value.
struct KnownExposures {
  std::vector<double> log_s;
  double sigma = 0.0;
  bool known = true;
};

constexpr std::size_t kCurveLevels = 256;
struct ResponseFit {
  std::string method;                        // "Mitsunaga-Nayar, order 3"
  std::array<std::vector<double>, 3> light;  // at kCurveLevels evenly spaced values 0..1, from 0 to 1, rising
  std::vector<double> log_s;                 // of the exposures, as found or given
  bool is_straight = false;                  // light is value
};

// Debevec and Malik 1997: ln light of each level and of each pixel by least squares. Smoothness is required over ln
// value, where every power law is straight, so that the curve is not bent in the dark. Then the bias that noise causes
// in the dark levels is removed. Needs known exposures. Empty: too little data, or the curve does not rise.
std::optional<ResponseFit> fit_debevec(const StackSamples& samples, const KnownExposures& exposures, double smoothness);
// Mitsunaga and Nayar 1999: a polynomial through black, fitted to every pair of neighbouring exposures, weighted by
// their quantisation; the exposures are refined with the curve. Empty: as above.
std::optional<ResponseFit> fit_mitsunaga(const StackSamples& samples, const KnownExposures& exposures, int order);

struct ResponseCandidate {
  std::string method;
  std::optional<double> held_out_steps;  // prediction error on pixels it was not fitted to; empty: does not fit
};
struct ResponseCalibration {
  ResponseFit fit;  // to all pixels
  double held_out_steps = 0.0;
  std::vector<ResponseCandidate> candidates;
  std::vector<std::string> undetermined;  // for a person
  Response response() const { return Response::table(fit.light); }
};
// Both methods with several orders and smoothnesses, compared by four-fold cross-validation over pixels; takes the
// simplest of those that are as good as the best. Errors (bad_input): the exposures overlap too little.
Result<ResponseCalibration> calibrate_response(const StackSamples& samples, const KnownExposures& exposures);
// For each exposure the rms of its values against their prediction by the pixels' other exposures, in steps of a value.
std::vector<double> prediction_errors(const StackSamples& samples, const ResponseFit& fit);

// Variance of light, full scale 1: shot noise grows with the light, read noise does not.
struct NoiseModel {
  double shot = 0.0;
  double read = 0.0;
  double variance(double light) const { return shot * std::max(0.0, light) + read; }
  double full_scale_electrons() const { return 1.0 / shot; }
  double read_electrons() const { return std::sqrt(read) / shot; }
};
// From the scatter between exposures of the same pixels, less quantisation. Medians keep the influence of a passing
// cloud small. Empty: too few values, or no noise above quantisation.
std::optional<NoiseModel> fit_noise(const StackSamples& samples, const ResponseFit& fit);

// The stack as one picture of linear light: each pixel the mean of its exposures, weighted by their noise, in units of
// the longest exposure's full scale. Where all are saturated, the shortest one's full scale.
Image<glm::vec3> merge_stack(const std::vector<Image<glm::vec3>>& pictures, double quantum, const glm::dvec3& black,
                             const ResponseFit& fit, const NoiseModel& noise);

// A curve found after subtracting the black level, as a table of raw encoded values: dark up to the black level, then
// the curve.
std::vector<double> over_black(const std::vector<double>& light, double black);

// Initial values for unknown exposures: the ratios of neighbours in `order` (by brightness) as if the camera were
// linear. Empty for pairs that do not overlap.
std::vector<std::optional<double>> linear_ratios(const StackSamples& samples, const std::vector<std::size_t>& order);
// The exposures from the darkest to the brightest.
std::vector<std::size_t> by_brightness(const StackSamples& samples);

}  // namespace kasumi
