// Renders text as a picture, for people in front of the screen: by Pango, so that letters of every script join, run and
// break as its readers expect.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "gles/picture/flat_picture.hpp"

namespace kasumi {

struct CaptionStyle {
  std::optional<std::filesystem::path> font_file{};  // empty: DejaVu Sans; what it lacks comes from other fonts
  std::string language{};       // ISO 639 code of the text, by which Chinese and Japanese share signs; empty: unknown
  double height_px = 32.0;      // of a line; of scripts that tower higher, more
  int largest_width_px = 1200;  // lines break before that, where the script's rules allow it
  int most_lines = 8;           // what does not fit is cut off, with dots
};

constexpr std::size_t kMostCaptionBytes = 10'000;  // bounds the time to lay it out; some 1500 words

// Light text on a dark, translucent, rounded background. `text` is UTF-8, line breaks are kept; lines are centred, and
// those of one paragraph about equally long.
// Errors: bad_input (font file unreadable, text not UTF-8 or too long), unsupported (no font on this machine). What no
// font can show becomes a box with its number.
Result<Image<Rgba8>> draw_caption(const std::string& text, const CaptionStyle& style);

// Whether it is whole in so many lines, and no word is cut. Errors as above.
Result<bool> caption_fits(const std::string& text, const CaptionStyle& style);

// What of a caption will not be seen as it is written, for people: a word that no installed font can show, with the
// Debian package that can; lines that are cut off. Empty: nothing. Errors as above.
Result<std::vector<std::string>> caption_faults(const std::string& text, const CaptionStyle& style);

}  // namespace kasumi
