// Pictures side by side, each with a caption.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"

namespace kasumi {

class ContactSheet {
 public:
  // Wider pictures are scaled down.
  explicit ContactSheet(int widest_px = 480) : widest_px_(widest_px) {}
  void add(const Image<Rgb8>& picture, std::string caption);
  // About square, or with the given number of columns. At least one picture must have been added.
  Image<Rgb8> drawn(int columns = 0) const;
  // PNG. Errors: bad_input (nothing was added), io.
  Result<> write(const std::filesystem::path& path) const;

 private:
  struct Tile {
    Image<Rgb8> picture;
    std::string caption;
  };
  int widest_px_;
  std::vector<Tile> tiles_;
};

}  // namespace kasumi
