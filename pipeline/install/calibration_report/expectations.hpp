// Expected quality of a calibration's numbers, and the steps of a complete one.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace kasumi {

enum class Verdict { good, usable, poor };
std::string_view name_of(Verdict verdict);  // "good", "usable", "not good enough"

// Of one number that a step notes under [CAMERA.measured.WHAT].
struct Expectation {
  std::string_view what, key;
  double good = 0.0, usable = 0.0;  // up to these; from these on where good > usable
  std::string_view unit;
  std::string_view remedy;  // for a person

  Verdict verdict(double value) const;
  std::string text() const;  // "0.05 deg or less"
};
std::optional<Expectation> expectation_of(std::string_view what, std::string_view key);

// A step of a complete calibration: done when [CAMERA.measured.WHAT] is there.
struct RequiredStep {
  std::string_view camera, what;
  std::string_view title;
  std::string_view missing;  // what is not known without it
  std::string_view command;
};
std::span<const RequiredStep> required_steps();

}  // namespace kasumi
