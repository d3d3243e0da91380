// The display and the stage on it, which come and go as one: opened when there is one, anew when it is lost.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "pipeline/appliance/status_mail.hpp"
#include "pipeline/machine/devices.hpp"
#include "pipeline/machine/watchdog.hpp"
#include "pipeline/stage/stage.hpp"

namespace kasumi {

// Belongs to the main thread, as GL and the display do. Keeps `news` up to date. Only look(), adopt(), close() and
// display() may be called while it is not open.
class Screen {
 public:
  // All references must outlive it.
  Screen(ContentPtr content, Devices& devices, Clock& clock, Watchdog& watchdog, DisplayNews& news);
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  bool is_open() const { return open_.has_value(); }
  // While it is not open: opens it when that is due; true: it is open now. BLOCKS for as long as the display's driver
  // takes.
  bool look();
  // When to look again; where it hears of displays that come and go, no later than `glance`.
  Instant next_look(Instant glance) const { return watch_ ? std::min(try_at_, glance) : try_at_; }

  // New content, on the display that it names. Errors: its stage's; the old content stays then.
  Result<> adopt(const ContentPtr& content);
  // A fault of the display: it is let go of, and opened anew.
  void lose(const Fault& fault);
  void close() { open_.reset(); }

  // A buffer to draw into; empty: none is free yet. BLOCKS for at most a quarter of a second. Errors: those of
  // Display::begin(), a timeout only when it lasts.
  Result<std::optional<DrawTarget>> begin();
  // Errors: those of Display::show(), or the context is lost.
  Result<std::uint64_t> show(std::shared_ptr<const void> until_replaced);
  std::vector<Flip> take_flips();
  bool nothing_shown() const { return open_->dark; }

  // Where that can be done; else it stays on. Errors: device, disconnected.
  Result<> turn_off();
  bool is_off() const { return open_->off; }
  void stay_on() { open_->off = open_->stays_on = false; }  // the next picture turns it on

  Stage& stage() { return open_->stage; }
  Display* display() { return open_ ? open_->display.get() : nullptr; }

 private:
  struct Open {
    std::unique_ptr<Display> display;
    Stage stage;  // all its GL objects are the display's context's
    bool dark = true;
    bool off = false;
    bool stays_on = false;  // it cannot be turned off
  };
  bool open();

  ContentPtr content_;
  Devices& devices_;
  Clock& clock_;
  Watchdog& watchdog_;
  DisplayNews& news_;
  std::unique_ptr<DisplayWatch> watch_;

  std::optional<Open> open_;
  std::optional<SceneAir> air_;  // what a stage that is lost had seen
  Instant try_at_;
  Instant tried_at_;
  bool wanted_ = false;                    // and said so in the log
  std::optional<Instant> timeouts_since_;  // no buffer to draw into since then
};

}  // namespace kasumi
