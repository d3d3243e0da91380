// A line or two over the picture, for the people in front of it. Drawn anew only when text or screen change.
#pragma once

#include <optional>
#include <string>

#include "gles/picture/flat_picture.hpp"
#include "pipeline/show/stage/caption.hpp"
#include "pipeline/site/config/run_config.hpp"

namespace kasumi {

// How words look on a picture of that size.
CaptionStyle style_of(const MessageOptions& options, int width, int height);

class Words {
 public:
  // At the top or the bottom of the target, in its middle. Words that cannot be rendered as they should are
  // logged once and drawn in the program's own letters.
  // Errors: device.
  Result<> draw(GlContext& context, const std::string& text, const MessageOptions& options, bool at_top, double opacity,
                const DrawTarget& target);

 private:
  void update(GlContext& context, const std::string& text, const MessageOptions& options, const DrawTarget& target);
  std::string text_;
  int target_width_ = 0;
  std::optional<FlatPicture> picture_;  // empty: no text, or it could not be rendered
};

}  // namespace kasumi
