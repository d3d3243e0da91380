#include "pipeline/install/calibration_report/expectations.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace kasumi {

namespace {

// Half of what a visitor or the estimate of T would notice; derived in docs/calibration.md.
constexpr std::array kExpectations{
    Expectation{"lens", "rms_px", 0.5, 1.0, "px", "drop blurred pictures; is the board flat, the focus locked?"},
    Expectation{"lens", "focal_sigma_percent", 0.1, 0.3, "%", "tilt the board by 30 deg and more, both ways"},
    Expectation{"lens", "centre_x_sigma_px", 0.5, 2.0, "px", "more pictures, out to the left and right edges"},
    Expectation{"lens", "centre_y_sigma_px", 0.5, 2.0, "px", "more pictures, out to the top and bottom edges"},
    Expectation{"lens", "covered", 0.8, 0.6, "", "take pictures with the board where the plot is grey"},
    Expectation{"orientation", "rms_px", 1.0, 2.0, "px", "is the lens calibrated? is the clock right?"},
    Expectation{"orientation", "azimuth_sigma_deg", 0.05, 0.3, "deg", "record the sun for three hours"},
    Expectation{"orientation", "tilt_east_sigma_deg", 0.1, 0.3, "deg", "calibrate the lens; record the sun longer"},
    Expectation{"orientation", "tilt_north_sigma_deg", 0.1, 0.3, "deg", "calibrate the lens; record the sun longer"},
    Expectation{"orientation", "centre_x_sigma_px", 0.5, 2.0, "px", "calibrate the lens"},
    Expectation{"orientation", "centre_y_sigma_px", 0.5, 2.0, "px", "calibrate the lens"},
    Expectation{"orientation", "focal_sigma_percent", 0.3, 1.0, "%", "calibrate the lens; record the sun longer"},
    Expectation{"pose", "rms_px", 1.5, 3.0, "px", "mark the landmarks again, enlarged"},
    Expectation{"pose", "misfit", 1.5, 2.5, "", "places or pixels are worse than stated: check the list of landmarks"},
    Expectation{"pose", "heading_sigma_deg", 0.02, 0.05, "deg", "more landmarks, to the left and to the right"},
    Expectation{"pose", "pitch_sigma_deg", 0.02, 0.05, "deg", "more landmarks whose altitude is known"},
    Expectation{"pose", "roll_sigma_deg", 0.1, 0.3, "deg", "landmarks far apart in the picture, or the horizon"},
    Expectation{"pose", "anywhere_sigma_deg", 0.02, 0.05, "deg", "landmarks near the corners of the picture"},
    Expectation{"pose", "focal_sigma_percent", 0.2, 0.5, "%", "landmarks far apart in the picture"},
    Expectation{"response", "held_out_steps", 1.0, 3.0, "steps", "keep camera and light steady; double each exposure"},
    Expectation{"colour", "gamma_error_expected", 0.01, 0.02, "", "clearer days, the sun high and low"},
    Expectation{"mask", "unsure_percent", 10.0, 20.0, "%", "check the plot and correct the mask in a paint program"},
    Expectation{"vignetting", "rim_sigma", 0.005, 0.01, "", "more pictures"},
    Expectation{"vignetting", "residual", 0.03, 0.08, "", "is the ground evenly lit, the sky clear?"},
};

constexpr std::array kRequiredSteps{
    RequiredStep{"sky", "lens", "Lens", "the lens, and with it every direction in the picture",
                 "kasumi calibrate lens PICTURE... --board 8x6 --out"},
    RequiredStep{"sky", "orientation", "Orientation", "where the camera looks", "kasumi calibrate sky RECORDING --out"},
    RequiredStep{"sky", "response", "Response", "how pixel values follow light",
                 "kasumi calibrate response PICTURE... --dark PICTURE... --out"},
    RequiredStep{"sky", "vignetting", "Vignetting", "how the picture darkens towards the rim",
                 "kasumi calibrate vignetting RECORDING --out"},
    RequiredStep{"sky", "colour", "Colour", "which colours the camera's channels see",
                 "kasumi calibrate colour RECORDING --cameras FOLDER --out"},
    RequiredStep{"sky", "mask", "Mask", "what in the picture is never sky", "kasumi calibrate mask RECORDING --out"},
    RequiredStep{"scene", "lens", "Lens", "the lens, and with it every direction in the picture",
                 "kasumi calibrate lens PICTURE... --board 8x6 --camera scene --out"},
    RequiredStep{"scene", "pose", "Pose", "where the camera looks, and so where the building stands",
                 "kasumi calibrate scene LANDMARKS --picture PICTURE --out"},
    RequiredStep{"scene", "response", "Response", "how pixel values follow light",
                 "kasumi calibrate response PICTURE... --camera scene --out"},
    RequiredStep{"scene", "vignetting", "Vignetting", "how the picture darkens towards the corners",
                 "kasumi calibrate response PICTURE... --flat PICTURE... --camera scene --out"},
    RequiredStep{"scene", "mask", "Mask", "what stands in front of the building",
                 "kasumi calibrate mask --picture PICTURE --strokes STROKES --out"},
};

}  // namespace

std::string_view name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::good: return "good";
    case Verdict::usable: return "usable";
    case Verdict::poor: break;
  }
  return "not good enough";
}

Verdict Expectation::verdict(double value) const {
  const double sign = good > usable ? -1.0 : 1.0;
  if (sign * value <= sign * good) return Verdict::good;
  return sign * value <= sign * usable ? Verdict::usable : Verdict::poor;
}

std::string Expectation::text() const {
  return fmt::format("{}{}{} or {}", good, unit.empty() ? "" : " ", unit, good > usable ? "more" : "less");
}

std::optional<Expectation> expectation_of(std::string_view what, std::string_view key) {
  const auto* const found =
      std::ranges::find_if(kExpectations, [&](const Expectation& e) { return e.what == what && e.key == key; });
  if (found == kExpectations.end()) return std::nullopt;
  return *found;
}

std::span<const RequiredStep> required_steps() {
  return kRequiredSteps;
}

}  // namespace kasumi
