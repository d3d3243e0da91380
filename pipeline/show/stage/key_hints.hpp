// What each of the visitors' buttons does, written at the foot of the picture in the buttons' order from left to right.
#pragma once

#include <string>
#include <vector>

#include "gles/picture/flat_picture.hpp"
#include "pipeline/show/stage/words.hpp"

namespace kasumi {

class KeyHints {
 public:
  // Each in the middle of its share of the width, in three lines at most; all smaller where one would not fit.
  // Errors: device.
  Result<> draw(GlContext& context, const std::vector<std::string>& texts, const MessageStyle& letters,
                const DrawTarget& target);
  double foot() const { return foot_; }  // of the picture, that they take: pixels

 private:
  std::vector<std::string> texts_;
  CaptionKey key_;
  std::vector<FlatPicture> labels_;
  double foot_ = 0.0;
};

}  // namespace kasumi
