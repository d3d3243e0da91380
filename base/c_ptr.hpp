// Owners of objects that C libraries return by pointer.
#pragma once

#include <memory>

namespace kasumi {

template <auto Free>
struct FreedBy {
  template <class T>
  void operator()(T* object) const {
    Free(object);
  }
};

// Like CPtr<udev, udev_unref>.
template <class T, auto Free>
using CPtr = std::unique_ptr<T, FreedBy<Free>>;

}  // namespace kasumi
