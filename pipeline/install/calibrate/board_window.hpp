// A window with the camera's picture, the corners found, the cells covered, and what to do next.
#pragma once

#include <memory>
#include <string>

#include "base/picture.hpp"
#include "calib/board/board_collector.hpp"
#include "gles/display/window.hpp"

namespace kasumi {

// What the window shows: grey picture, green over covered cells, red over uncovered ones, the corners, and a
// message at the top.
Image<Rgb8> draw_coverage(const Image<std::uint8_t>& grey, const BoardCollector& collector, const std::string& message);

class BoardWindow {
 public:
  // Errors: unsupported (no display).
  static Result<BoardWindow> open();
  // Returns false when the window is to close. Errors: device.
  Result<bool> show(const Image<std::uint8_t>& grey, const BoardCollector& collector, const std::string& message);

 private:
  explicit BoardWindow(std::unique_ptr<Window> window) : window_(std::move(window)) {}
  std::unique_ptr<Window> window_;
};

}  // namespace kasumi
