#include "pipeline/stage/text_breaking.hpp"

#include <algorithm>

namespace kasumi {
namespace {

constexpr bool is_space(char32_t c) {  // where a line may break; U+00A0 and U+202F are non-breaking
  return c == U' ' || c == U'\t' || c == U'\u3000';
}

// Kana, ideographs, Hangul, full-width forms.
constexpr bool is_without_spaces(char32_t c) {
  return (c >= 0x2E80 && c <= 0x9FFF) || (c >= 0xAC00 && c <= 0xD7AF) || (c >= 0xF900 && c <= 0xFAFF) ||
         (c >= 0xFF00 && c <= 0xFFEF) || (c >= 0x20000 && c <= 0x3FFFF);
}

constexpr std::u32string_view kNeverFirst =
    U"、。，．・：；？！ー々〻ヽヾゝゞぁぃぅぇぉっゃゅょゎァィゥェォッャュョヮヵヶ）］｝〕〉》」』】〙〗〟’”)]},.:;!?%"
    U"…‥";
constexpr std::u32string_view kNeverLast = U"（［｛〔〈《「『【〘〖〝‘“([{";

bool may_break_between(char32_t before, char32_t after) {
  if (is_space(before) || is_space(after)) return true;
  if (kNeverFirst.find(after) != std::u32string_view::npos) return false;
  if (kNeverLast.find(before) != std::u32string_view::npos) return false;
  return is_without_spaces(before) || is_without_spaces(after);
}

std::u32string_view trimmed(std::u32string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

// Greedy: each line takes as much as fits.
std::vector<std::u32string_view> filled(std::u32string_view rest, double largest, const WidthOf& width_of) {
  std::vector<std::u32string_view> lines;
  for (rest = trimmed(rest); !rest.empty(); rest = trimmed(rest)) {
    std::size_t end = 0, forced = 1;
    for (std::size_t at = 1; at <= rest.size(); ++at) {
      const bool fits = width_of(trimmed(rest.substr(0, at))) <= largest;
      if (fits) forced = at;
      if (at < rest.size() && !may_break_between(rest[at - 1], rest[at])) continue;
      if (!fits) break;
      end = at;
    }
    if (end == 0) end = forced;
    lines.push_back(trimmed(rest.substr(0, end)));
    rest.remove_prefix(end);
  }
  if (lines.empty()) lines.emplace_back();
  return lines;
}

// The narrowest lines of the same number, since a last line of one word reads badly.
std::vector<std::u32string_view> balanced(std::u32string_view paragraph, double largest, const WidthOf& width_of) {
  auto lines = filled(paragraph, largest, width_of);
  if (lines.size() < 2) return lines;
  double too_narrow = 0.0, wide_enough = largest;
  for (int i = 0; i < 12; ++i) {
    const double width = 0.5 * (too_narrow + wide_enough);
    auto narrower = filled(paragraph, width, width_of);
    const bool fits = std::ranges::all_of(narrower, [&](std::u32string_view line) { return width_of(line) <= width; });
    if (fits && narrower.size() <= lines.size()) {
      wide_enough = width;
      lines = std::move(narrower);
    } else {
      too_narrow = width;
    }
  }
  return lines;
}

}  // namespace

Result<std::u32string> characters_of(std::string_view utf8) {
  std::u32string text;
  for (std::size_t at = 0; at < utf8.size();) {
    const auto lead = static_cast<unsigned char>(utf8[at]);
    const int more = lead < 0x80                   ? 0
                     : lead >= 0xC2 && lead < 0xE0 ? 1
                     : lead >= 0xE0 && lead < 0xF0 ? 2
                     : lead >= 0xF0 && lead < 0xF5 ? 3
                                                   : -1;
    char32_t c = more == 0 ? lead : static_cast<char32_t>(lead & (0x3Fu >> static_cast<unsigned>(std::max(more, 0))));
    bool good = more >= 0 && at + static_cast<std::size_t>(more) < utf8.size();
    for (int i = 1; good && i <= more; ++i) {
      const auto next = static_cast<unsigned char>(utf8[at + static_cast<std::size_t>(i)]);
      good = (next & 0xC0u) == 0x80u;
      c = c << 6u | (next & 0x3Fu);
    }
    const bool overlong = (more == 2 && c < 0x800) || (more == 3 && c < 0x10000);
    if (!good || overlong || (c >= 0xD800 && c < 0xE000) || c > 0x10FFFF)
      return fail(FaultKind::bad_input, "text: byte {} ({:#04x}) is not UTF-8", at, lead);
    text.push_back(c);
    at += static_cast<std::size_t>(more) + 1;
  }
  return text;
}

std::vector<std::u32string> break_lines(std::u32string_view text, double largest, const WidthOf& width_of) {
  std::vector<std::u32string> lines;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(U'\n', at), text.size());
    for (const auto line : balanced(text.substr(at, end - at), largest, width_of)) lines.emplace_back(line);
    at = end + 1;
  }
  return lines;
}

}  // namespace kasumi
