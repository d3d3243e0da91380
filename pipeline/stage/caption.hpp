// Renders text as a picture, for people in front of the screen.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/result.hpp"
#include "gles/picture/flat_picture.hpp"

namespace kasumi {

struct CaptionStyle {
  std::optional<std::filesystem::path> font_file{};  // empty: DejaVu Sans or another installed font
  double height_px = 32.0;                           // of a line
  int largest_width_px = 1200;  // lines break before that, at spaces (between any two characters where a
                                // script has no spaces)
};

// Light text on a dark, translucent, rounded background. `text` is UTF-8, line breaks are kept.
// Errors: bad_input (font file unreadable, text not UTF-8), unsupported (no font on this machine). Characters the font
// lacks become its box.
Result<Image<Rgba8>> draw_caption(const std::string& text, const CaptionStyle& style);

}  // namespace kasumi
