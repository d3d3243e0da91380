// A line or two over the picture, for the people in front of it. Drawn anew only when text or screen change.
#pragma once

#include <optional>
#include <string>

#include "gles/picture/flat_picture.hpp"
#include "pipeline/show/stage/caption.hpp"
#include "pipeline/site/config/run_config.hpp"

namespace kasumi {

// How words look on a picture of that size.
CaptionStyle style_of(const MessageStyle& options, int width, int height);

// The same for labels beside each other: on a screen that stands upright letters go by its width.
CaptionStyle label_style_of(const MessageStyle& options, int width, int height);

// Words that cannot be rendered as they should, or not in time, are logged and drawn in the program's own letters.
Image<Rgba8> picture_of_words(const std::string& text, const MessageStyle& options, const CaptionStyle& style);

// What a text's picture depends on, besides the text.
struct CaptionKey {
  Language language = Language::english;
  double print = 1.0;
  int target_width = 0;
  friend bool operator==(const CaptionKey&, const CaptionKey&) = default;
};

class Words {
 public:
  // At the top or the bottom of the target, in its middle. Errors: device.
  Result<> draw(GlContext& context, const std::string& text, const MessageStyle& options, bool at_top, double opacity,
                const DrawTarget& target);

 private:
  void update(GlContext& context, const std::string& text, const MessageStyle& options, const DrawTarget& target);
  std::string text_;
  CaptionKey key_;
  std::optional<FlatPicture> picture_;  // empty: no text, or it could not be rendered
  bool waits_for_fonts_ = false;        // shown in plain letters until the disk answers
};

}  // namespace kasumi
