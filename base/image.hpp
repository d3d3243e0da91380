// A two-dimensional array that owns its elements, with packed rows and the origin at the top left.
#pragma once

#include <cstddef>
#include <vector>

namespace kasumi {

template <class T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, const T& fill = T{})
      : width_(width),
        height_(height),
        elements_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), fill) {}

  int width() const { return width_; }
  int height() const { return height_; }
  bool empty() const { return elements_.empty(); }
  bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }

  T& at(int x, int y) { return elements_[index(x, y)]; }
  const T& at(int x, int y) const { return elements_[index(x, y)]; }
  T* row(int y) { return elements_.data() + index(0, y); }
  const T* row(int y) const { return elements_.data() + index(0, y); }
  std::vector<T>& elements() { return elements_; }
  const std::vector<T>& elements() const { return elements_; }

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }

  int width_ = 0;
  int height_ = 0;
  std::vector<T> elements_;
};

}  // namespace kasumi
