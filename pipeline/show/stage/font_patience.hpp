// Text is drawn from fonts on a disk, which may not answer: the thread that shows pictures waits for it no longer than
// this.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <system_error>

#include "base/outside/abandonable.hpp"

namespace kasumi {

// Above the first use of fonts on a slow machine without fontconfig's cache; below what a watchdog bears.
constexpr std::chrono::seconds kFontDeadline{3};

// How many calls of with_fonts() still wait for a disk after their deadline.
inline std::atomic<int> hung_fonts = 0;

// BLOCKS for at most kFontDeadline, and not at all while another call waits beyond it. Empty: the disk does not answer,
// or the machine has no thread left to wait in. `work` must own what it uses.
template <class T>
std::optional<T> with_fonts(std::function<T()> work) {
  enum State { working, ended, left };
  if (hung_fonts > 0) return std::nullopt;
  auto state = std::make_shared<std::atomic<State>>(working);
  const auto counted = [state, work = std::move(work)] {
    struct End {
      std::atomic<State>& state;
      ~End() {
        if (state.exchange(ended) == left) --hung_fonts;
      }
    } end{*state};
    return work();
  };
  try {
    if (auto made = within<T>(kFontDeadline, counted)) return made;
  } catch (const std::system_error&) {  // no thread
    return std::nullopt;
  }
  ++hung_fonts;
  if (state->exchange(left) == ended) --hung_fonts;
  return std::nullopt;
}

}  // namespace kasumi
