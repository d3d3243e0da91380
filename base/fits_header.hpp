// Keywords of a FITS file's first header (IAU FITS 4.0), read before anything is decoded.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace kasumi {

inline bool is_fits(std::span<const std::uint8_t> file) {
  constexpr std::string_view kBegin = "SIMPLE  =";
  return file.size() >= kBegin.size() && std::equal(kBegin.begin(), kBegin.end(), file.begin());
}
// The value without quotes and the blanks at its end; empty: the keyword is not there, or its line is no value.
std::optional<std::string> fits_value(std::span<const std::uint8_t> file, std::string_view keyword);
// What stands behind its slash; empty: nothing.
std::optional<std::string> fits_comment(std::span<const std::uint8_t> file, std::string_view keyword);

}  // namespace kasumi
