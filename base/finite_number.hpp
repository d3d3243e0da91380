// A number that a person wrote.
#pragma once

#include <cmath>
#include <cstdlib>
#include <optional>
#include <string>

namespace kasumi {

// Empty: not a number from end to end, or not a finite one.
inline std::optional<double> finite_number(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

}  // namespace kasumi
