// Decodes UTF-8 text and breaks it into lines.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace kasumi {

// Error (bad_input): not UTF-8, with the byte's offset.
Result<std::u32string> characters_of(std::string_view utf8);

// Where each character of a text lies when it is written on one line.
struct GlyphExtent {
  double from = 0.0, to = 0.0;
};
using ExtentsOf = std::function<std::vector<GlyphExtent>(std::u32string_view)>;

// Lines no wider than `largest` where that is possible: they end at line feeds, at spaces (which are dropped), and
// between the characters of scripts without spaces, though never before a closing mark or after an opening one
// (kinsoku). A word wider than a whole line is cut. At least one line. Lines of one paragraph are made about equally
// long. Each character is measured once.
std::vector<std::u32string> break_lines(std::u32string_view text, double largest, const ExtentsOf& extents_of);

}  // namespace kasumi
