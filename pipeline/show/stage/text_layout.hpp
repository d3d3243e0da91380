// Text of any script, laid out by Pango and drawn by Cairo as outlines, so that no glyph, however large its font says it
// is, takes more memory than the picture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/image.hpp"
#include "base/result.hpp"

namespace kasumi {

constexpr double kLineOverEm = 1.2;  // distance of lines in units of the letters' size, as in print

struct TextStyle {
  std::optional<std::filesystem::path> font_file{};  // before all others
  std::string language{};                            // ISO 639; empty: unknown
  double line_px = 32.0;
  double largest_width_px = 1200.0;
  int most_lines = 8;
  bool from_the_start = false;  // lines begin where their script does, left or right; else they are centred
};

class TextLayout {
 public:
  // Errors: bad_input (not UTF-8; the font file), unsupported (no font at all).
  static Result<TextLayout> of(const std::string& text, const TextStyle& style);

  double em_px() const { return em_px_; }
  double width() const { return width_; }             // of the widest line, in pixels
  double height() const { return height_; }           // of all
  std::size_t left_out() const { return left_out_; }  // lines that were one too many
  bool cuts_words() const;                            // a word is wider than a line
  // Coverage, 0..255, the first line from `top` on; lines are centred in the width, or `side` from its edge. Errors: out of
  // memory (device).
  Result<Image<std::uint8_t>> draw(int width, int height, double top, double side = 0.0) const;

  struct Missing {
    std::string text, package;  // a word with letters that no font has; what brings one (empty: none)
  };
  std::vector<Missing> missing() const;  // each once

 private:
  struct Parts;  // Pango's
  struct CloseParts {
    void operator()(Parts* parts) const;
  };
  struct Line {
    int number = 0;
    double width = 0.0, baseline = 0.0;  // from the first line's top
    bool leftwards = false;
  };
  explicit TextLayout(std::unique_ptr<Parts, CloseParts> parts) : parts_(std::move(parts)) {}
  void balance(double largest_px, int most_lines);
  void place_lines(double line_px, int most_lines);

  std::unique_ptr<Parts, CloseParts> parts_;
  std::string text_;
  std::vector<Line> lines_;
  bool from_the_start_ = false;
  double em_px_ = 0.0, width_ = 0.0, height_ = 0.0;
  std::size_t left_out_ = 0;
};

}  // namespace kasumi
