// Where a picture is drawn to.
#pragma once

namespace kasumi {

// A framebuffer of the current context. The camera's picture is shown as large as fits, with its aspect ratio kept,
// centred on black.
struct DrawTarget {
  unsigned framebuffer = 0;  // GL name; 0 is the window's own
  int width = 0;             // pixels of the framebuffer
  int height = 0;
  bool top_row_first =
      false;  // row 0 is the picture's top (offscreen framebuffers, read back in that order); a window's
              // row 0 is its bottom
};

// The part of a target that shows the picture, in the target's rows.
struct Letterbox {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  friend bool operator==(const Letterbox&, const Letterbox&) = default;
};
Letterbox letterbox(const DrawTarget& target, int picture_width, int picture_height);

}  // namespace kasumi
