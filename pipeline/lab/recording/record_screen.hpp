// What the display shows while recording: the scene camera's picture, and a caption that it is kept.
#pragma once

#include <optional>
#include <string>

#include "capture/frame.hpp"
#include "gles/composite/renderer.hpp"
#include "gles/display/display.hpp"
#include "gles/picture/flat_picture.hpp"
#include "pipeline/site/config/run_config.hpp"

namespace kasumi {

// Belongs to the thread of its display.
class RecordScreen {
 public:
  static Result<RecordScreen> open(std::unique_ptr<Display> display, const RunConfig& config);
  // Shows the picture (nothing new: the last one) under the caption with these text. BLOCKS until there is a buffer to
  // draw into, or the deadline passes: no error. Errors: as Display's.
  Result<> show(const Frame* frame, const std::string& text, Instant deadline);
  Display& display() { return *display_; }

 private:
  RecordScreen(std::unique_ptr<Display> display, Renderer renderer, FlatPicture light, const RunConfig& config)
      : display_(std::move(display)),
        renderer_(std::move(renderer)),
        light_(std::move(light)),
        encoding_(config.installation.scene.yuv_encoding),
        font_(config.messages.font_file) {}
  Result<> set_text(const std::string& text, const DrawTarget& target);

  std::unique_ptr<Display> display_;  // declared first, since everything below belongs to its context
  Renderer renderer_;
  FlatPicture light_;
  YuvEncoding encoding_;
  std::optional<std::filesystem::path> font_;
  std::optional<FlatPicture> caption_;
  std::string text_;
  int caption_for_height_ = 0;
  bool has_picture_ = false;
};

}  // namespace kasumi
