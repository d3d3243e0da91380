#include "base/fits_header.hpp"

#include <algorithm>

namespace kasumi {
namespace {

constexpr std::size_t kCard = 80, kValueAt = 10, kNameSize = 8;
constexpr std::size_t kMostCards = 36 * 100;

std::string_view without_blanks_behind(std::string_view text) {
  return text.substr(0, text.find_last_not_of(' ') + 1);
}

// Behind "KEYWORD = "; empty: not there.
std::string_view card_of(std::span<const std::uint8_t> file, std::string_view keyword) {
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  for (std::size_t at = 0, count = 0; at + kCard <= text.size() && count < kMostCards; at += kCard, ++count) {
    const auto card = text.substr(at, kCard), name = without_blanks_behind(card.substr(0, kNameSize));
    if (name == "END") return {};
    if (name == keyword && card.substr(kNameSize, 2) == "= ") return card.substr(kValueAt);
  }
  return {};
}

}  // namespace

std::optional<std::string> fits_value(std::span<const std::uint8_t> file, std::string_view keyword) {
  auto value = card_of(file, keyword);
  if (value.empty()) return std::nullopt;
  value.remove_prefix(std::min(value.find_first_not_of(' '), value.size()));
  if (!value.starts_with('\'')) return std::string(without_blanks_behind(value.substr(0, value.find('/'))));
  const auto end = value.find('\'', 1);
  if (end == std::string_view::npos) return std::nullopt;
  return std::string(without_blanks_behind(value.substr(1, end - 1)));
}

std::optional<std::string> fits_comment(std::span<const std::uint8_t> file, std::string_view keyword) {
  auto card = card_of(file, keyword);
  const auto quote = card.find_first_not_of(' ');
  if (quote != std::string_view::npos && card[quote] == '\'') {
    const auto end = card.find('\'', quote + 1);
    card = end == std::string_view::npos ? std::string_view() : card.substr(end);
  }
  const auto slash = card.find('/');
  return slash == std::string_view::npos ? std::nullopt
                                         : std::optional(std::string(without_blanks_behind(card.substr(slash + 1))));
}

}  // namespace kasumi
