// A progress bar for a person at a terminal; silent when standard error is not one.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

namespace kasumi {

class Progress {
 public:
  Progress(std::string title, std::size_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void advance(std::string_view detail);

 private:
  void draw(std::string_view detail);
  std::string title_;
  std::size_t total_;
  std::size_t done_ = 0;
  bool terminal_;
  std::chrono::steady_clock::time_point drawn_{};
};

}  // namespace kasumi
