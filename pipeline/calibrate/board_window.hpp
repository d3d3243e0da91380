// A window that shows the camera's picture with the corners found, the cells that are covered, and what to do next.
#pragma once

#include <memory>
#include <string>

#include "base/picture.hpp"
#include "calib/board/board_collector.hpp"
#include "gles/display/window.hpp"

namespace kasumi {

// What the window shows: grey picture, green over covered cells, red over bare ones, the corners, message at the top.
Image<Rgb8> draw_coverage(const Image<std::uint8_t>& grey, const BoardCollector& collector, const std::string& message);

class BoardWindow {
 public:
  // Errors: unsupported (no display).
  static Result<BoardWindow> open();
  // false once it is to be closed. Errors: device.
  Result<bool> show(const Image<std::uint8_t>& grey, const BoardCollector& collector, const std::string& message);

 private:
  explicit BoardWindow(std::unique_ptr<Window> window) : window_(std::move(window)) {}
  std::unique_ptr<Window> window_;
};

}  // namespace kasumi
