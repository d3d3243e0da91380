// Between the thread that opens and reads an input device, whose driver may never return, and the one that draws, which
// never waits for it.
#pragma once

#include <atomic>
#include <functional>
#include <memory>

#include "base/latest_slot.hpp"
#include "pipeline/machine/buttons/input_reader.hpp"

namespace kasumi {

constexpr Duration kInputDeadline = std::chrono::seconds(3);  // a driver that is silent for longer hangs
constexpr std::size_t kMostInputWaiting = 1024;               // events that were not taken; more let go of all

class InputLink {
 public:
  // `options`: with one device. `news` is called, until end(), from the device's thread when there are events.
  InputLink(VisitorOptions options, Instant now, std::function<void()> news = {});
  const VisitorOptions& options() const { return options_; }

  // The device's thread. Opens or reads the device once: BLOCKS for as long as its driver does. `reader`: of options().
  void turn(InputReader& reader, Instant now);
  bool ended() const { return ended_; }

  // The drawing thread. What came since the last call; of a device that hangs, once, that it is gone.
  std::vector<HandEvent> take(Instant now);
  const InputDeviceState& state() const { return state_; }  // as of the last take()
  void end();

 private:
  struct News {
    std::vector<HandEvent> events;
    InputDeviceState state;
  };
  const VisitorOptions options_;
  std::atomic<Duration::rep> turned_;
  std::atomic<bool> ended_ = false;
  LatestSlot<News> news_;
  Mutex mutex_;
  std::function<void()> tell_ KASUMI_GUARDED_BY(mutex_);
  InputDeviceState told_, state_;
  bool hung_ = false;
};

// Turns the link in a thread of its own until it ends. A thread whose driver hangs is left behind, and counts as
// abandoned (base/outside/abandonable.hpp).
void serve_input(std::shared_ptr<InputLink> link, InputReader::Opener opener);

}  // namespace kasumi
