// Progress for a person at a terminal, on a line that is drawn anew; when standard error is none silent, or a line now
// and then for a job's log.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace kasumi {

// "estimate [######........] 12/30, 1.9/s, 0:10 left"; without a total "estimate 12, 1.9/s".
std::string progress_text(std::string_view title, std::size_t done, std::optional<std::size_t> total,
                          std::chrono::duration<double> elapsed);

class Progress {
 public:
  // `total` is empty where it is not known. `log_every`: between lines of a log; empty: none.
  Progress(std::string title, std::optional<std::size_t> total,
           std::optional<std::chrono::seconds> log_every = std::nullopt);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  // Draws the line at most 20 times a second.
  void advance(std::string_view detail);
  // Before something else is written to the terminal; the next step draws the line again at once.
  void clear();

 private:
  void draw(std::string_view detail);
  std::string title_;
  std::optional<std::size_t> total_;
  std::size_t done_ = 0;
  bool terminal_;
  std::optional<std::chrono::seconds> log_every_;
  std::chrono::steady_clock::time_point started_, drawn_{};
};

}  // namespace kasumi
