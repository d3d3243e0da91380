#include "pipeline/show/stage/text_breaking.hpp"

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

// Of a line, after JIS X 4051 (kinsoku).
constexpr std::u32string_view kNeverFirst =
    U"、。，．・：；？！ー々〻ヽヾゝゞぁぃぅぇぉっゃゅょゎァィゥェォッャュョヮヵヶ）］｝〕〉》」』】〙〗〟’”)]},.:;!?%"
    U"…‥";
constexpr std::u32string_view kNeverLast = U"（［｛〔〈《「『【〘〖〝‘“([{";  // of a line

bool may_break_between(char32_t before, char32_t after) {
  if (is_space(before) || is_space(after)) return true;
  if (kNeverFirst.find(after) != std::u32string_view::npos) return false;
  if (kNeverLast.find(before) != std::u32string_view::npos) return false;
  return is_without_spaces(before) || is_without_spaces(after);
}

struct Line {
  std::size_t from = 0, to = 0;  // characters
};

// Text between two line feeds, measured once.
class Paragraph {
 public:
  Paragraph(std::u32string_view text, const ExtentsOf& extents_of) : text_(text), extents_(extents_of(text)) {}

  // The narrowest lines of the number that it takes, since a last line of one word reads badly.
  std::vector<Line> balanced(double largest) const;
  std::u32string_view text(const Line& line) const { return text_.substr(line.from, line.to - line.from); }

 private:
  double width(const Line& line) const {
    return line.to > line.from ? extents_[line.to - 1].to - extents_[line.from].from : 0.0;
  }
  std::vector<Line> filled(double largest) const;
  Line first_line(std::size_t from, double largest) const;
  std::size_t after_spaces(std::size_t at) const {
    while (at < text_.size() && is_space(text_[at])) ++at;
    return at;
  }

  std::u32string_view text_;
  std::vector<GlyphExtent> extents_;
};

// As much as fits, from a character that is no space; a single character where nothing does.
Line Paragraph::first_line(std::size_t from, double largest) const {
  Line fits{from, from + 1}, whole{from, from};
  std::size_t last = from;  // what follows are spaces
  for (std::size_t at = from + 1; at <= text_.size(); ++at) {
    if (!is_space(text_[at - 1])) last = at;
    if (width({from, last}) > largest) break;
    fits.to = last;
    if (at == text_.size() || may_break_between(text_[at - 1], text_[at])) whole.to = last;
  }
  return whole.to > from ? whole : fits;
}

// Greedy: each line takes as much as fits.
std::vector<Line> Paragraph::filled(double largest) const {
  std::vector<Line> lines;
  for (auto from = after_spaces(0); from < text_.size(); from = after_spaces(lines.back().to))
    lines.push_back(first_line(from, largest));
  if (lines.empty()) lines.emplace_back();
  return lines;
}

std::vector<Line> Paragraph::balanced(double largest) const {
  auto lines = filled(largest);
  if (lines.size() < 2) return lines;
  double too_narrow = 0.0, wide_enough = largest;
  for (int i = 0; i < 12; ++i) {
    const double tried = 0.5 * (too_narrow + wide_enough);
    auto narrower = filled(tried);
    const bool fits = std::ranges::all_of(narrower, [&](const Line& line) { return width(line) <= tried; });
    if (fits && narrower.size() <= lines.size()) {
      wide_enough = tried;
      lines = std::move(narrower);
    } else {
      too_narrow = tried;
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

std::vector<std::u32string> break_lines(std::u32string_view text, double largest, const ExtentsOf& extents_of) {
  std::vector<std::u32string> lines;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(U'\n', at), text.size());
    const Paragraph paragraph(text.substr(at, end - at), extents_of);
    for (const auto& line : paragraph.balanced(largest)) lines.emplace_back(paragraph.text(line));
    at = end + 1;
  }
  return lines;
}

}  // namespace kasumi
