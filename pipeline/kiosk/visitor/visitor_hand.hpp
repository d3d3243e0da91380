// What a visitor's hand has chosen, as it is to be seen. Without a hand for a while everything is as it was, so that one
// visitor's choice never meets the next.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "base/clock.hpp"
#include "pipeline/site/visitor/hand_event.hpp"

namespace kasumi {

class VisitorHand {
 public:
  struct Limits {
    std::size_t eras = 1, languages = 1;  // to choose from; at least one
    double notch = 0.05;
    Duration idle = std::chrono::seconds(45);
  };
  struct Choice {
    double bare = 0.0;         // from the left, of the screen's width: the camera's picture alone
    std::size_t era = 0;       // so many after the one of the day
    std::size_t language = 0;  // so many after the configured one
    bool large_print = false;
    std::size_t story = 0;  // 0: none
    std::size_t view = 0;   // a BuildingView; 0: live
    friend bool operator==(const Choice&, const Choice&) = default;
  };

  explicit VisitorHand(const Limits& limits) : limits_(limits) {}
  // In the order of time. Events without meaning change nothing.
  void take(const HandEvent& event, Instant now);
  // How many stories there are to read now: one that is there no longer is closed.
  void offer_stories(std::size_t count);
  // Lets what moves move, and time pass.
  void step(Instant now);

  const Choice& choice() const { return choice_; }
  bool is_idle() const { return !touched_at_; }
  bool is_moving() const { return glide_.has_value(); }
  // What was pressed last, for some seconds after: the screen says what it did.
  std::optional<HandKey> pressed(Instant now) const;
  // Of each key since the start; wiping by touch or knob counts as then_and_now, once for each time.
  const std::array<std::uint64_t, kHandKeys>& presses() const { return presses_; }

 private:
  struct Glide {
    double from = 0.0, to = 0.0;
    Instant began;
    Duration lasts{};
  };
  void glide(double to, Duration lasts, Instant now);
  void let_go(Instant now);
  void press(HandKey key, Instant now);
  void count(HandKey key) { ++presses_[static_cast<std::size_t>(key)]; }

  Limits limits_;
  Choice choice_;
  std::size_t stories_ = 0;
  bool held_ = false, touching_ = false;
  std::optional<Instant> turned_at_;   // and not let go since
  std::optional<Instant> touched_at_;  // anything; empty: idle
  std::optional<Glide> glide_;
  std::optional<HandKey> pressed_;
  Instant pressed_at_;
  std::array<std::uint64_t, kHandKeys> presses_{};
};

}  // namespace kasumi
