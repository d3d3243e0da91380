#include "base/fits_header.hpp"

#include <algorithm>

namespace kasumi {
namespace {

constexpr std::size_t kCard = 80, kValueAt = 10, kNameSize = 8;
constexpr std::size_t kMostCards = 36 * 100;

std::string_view without_blanks_behind(std::string_view text) {
  return text.substr(0, text.find_last_not_of(' ') + 1);
}

}  // namespace

std::optional<std::string> fits_value(std::span<const std::uint8_t> file, std::string_view keyword) {
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  for (std::size_t at = 0, count = 0; at + kCard <= text.size() && count < kMostCards; at += kCard, ++count) {
    const auto card = text.substr(at, kCard), name = without_blanks_behind(card.substr(0, kNameSize));
    if (name == "END") return std::nullopt;
    if (name != keyword || card.substr(kNameSize, 2) != "= ") continue;
    auto value = card.substr(kValueAt);
    value.remove_prefix(std::min(value.find_first_not_of(' '), value.size()));
    if (value.starts_with('\'')) {
      const auto end = value.find('\'', 1);
      if (end == std::string_view::npos) return std::nullopt;
      return std::string(without_blanks_behind(value.substr(1, end - 1)));
    }
    return std::string(without_blanks_behind(value.substr(0, value.find('/'))));
  }
  return std::nullopt;
}

}  // namespace kasumi
