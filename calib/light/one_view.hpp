// Whether pictures can be exposures of one view. Any pictures yield some response curve, so this is checked beforehand,
// and the curve's own prediction of the pictures afterwards.
#pragma once

#include <optional>

#include "calib/light/exposure_stack.hpp"

namespace kasumi {

// Two pictures, after the best rising tone curve between them. Cells: small squares that are neither dark nor saturated
// in either; their mean green is compared.
struct ViewAgreement {
  double rank_correlation = 0.0;  // Spearman's
  double residual_steps = 0.0;    // rms of the brighter picture around that curve, of 255
  bool one_view() const;
};
// Empty: too few cells are usable in both. Cells of which any pixel's mask is 0 are not.
std::optional<ViewAgreement> compare_views(const Image<glm::vec3>& a, const Image<glm::vec3>& b,
                                           const Image<std::uint8_t>& mask);

// Errors (bad_input): pictures that no tone curve turns into any of the largest group that agrees, each named with the
// picture it is most like.
Result<> check_one_view(const ExposureStack& stack, const Image<std::uint8_t>& mask);

// Errors (bad_input): all exposures are the same within 5 %, which says nothing of the curve.
Result<> check_exposure_ratios(const KnownStack& known);

// Errors (bad_input): the curve predicts the pictures to more than 3 steps of 255 (rms).
Result<> check_prediction(const ResponseCalibration& calibration, const StackSamples& samples, const KnownStack& known);

}  // namespace kasumi
