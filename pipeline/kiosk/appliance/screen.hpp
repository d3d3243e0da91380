// The display and the stage drawn on it, which are opened and lost together; reopened after a fault.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/kiosk/appliance/mailboxes.hpp"
#include "pipeline/kiosk/appliance/status_mailbox.hpp"
#include "pipeline/machine/devices.hpp"
#include "pipeline/machine/watchdog.hpp"
#include "pipeline/show/stage/plane_mode.hpp"
#include "pipeline/show/stage/stage.hpp"

namespace kasumi {

// Belongs to the main thread, as GL and the display do. Keeps `status` up to date. While it is
// not open, only try_open(), adopt(), close() and display() may be called.
class Screen {
 public:
  // All references must outlive it.
  Screen(ContentPtr content, Devices& devices, Clock& clock, Watchdog& watchdog, DisplayStatus& status);
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  bool is_open() const { return open_.has_value(); }
  // Opens the display when an attempt is due; true: it is open now. BLOCKS for as long as its driver takes.
  bool try_open();
  // Why GL refused the content's stage, the display being well; empty: it did not. The still picture with words is on the
  // glass then, or a second has passed, and stays there until this ends: other content is needed.
  std::string refused() const { return refused_ && refused_->told ? refused_->why : std::string(); }
  // When to call try_open() again: no later than `poll` where hotplug events are reported.
  Instant next_attempt(Instant poll) const { return watch_ ? std::min(try_at_, poll) : try_at_; }

  // Switches to new content and to the display that it names. `stage`: the content's, made under this display; empty:
  // it is made now. Errors: those of Stage::create(); the old content stays.
  Result<> adopt(const ContentPtr& content, std::optional<Stage> stage);
  // Closes the display after a fault; the next try_open() reopens it.
  void handle_fault(const Fault& fault);
  void close() {
    open_.reset();
    status_.up = false;
  }

  // A buffer to draw into; empty: none is free yet. BLOCKS for at most a quarter of a second. Errors: those of
  // Display::begin(), but a timeout only when it persists.
  Result<std::optional<DrawTarget>> begin();
  // Errors: those of Display::show(), or device when the GL context is lost.
  Result<std::uint64_t> show(std::shared_ptr<const void> until_replaced);
  // The scene without the GPU, where nothing lies over it: a new frame, which the stage takes, or (null) as it is.
  // `before`: called once the stage has what is to be shown. Errors: device, disconnected.
  struct OnPlanes {
    PlaneMode::Outcome outcome = PlaneMode::Outcome::compose;
    std::uint64_t number = 0;  // of the picture shown
    bool taken = false;        // the frame
  };
  Result<OnPlanes> try_planes(const SceneFrame* frame, const SkyReport& sky, const Composition& composition,
                              const std::function<Result<>()>& before);
  // The camera's buffers must no longer be shown until they have been dropped.
  void lose_camera() { camera_gone_ = true; }
  // Gives buffers back that the GPU still holds of a camera that is gone; true: it did. Errors: device.
  Result<bool> drop_lost_buffers();
  void report_drawing() {
    status_.planes = open_ ? open_->planes.state() : "";
    status_.mixing = !open_ ? "" : open_->stage.scene().processor_mixes() ? "processor" : "gpu";
  }
  std::vector<Flip> take_flips();
  bool nothing_shown() const { return open_->dark; }

  // Where the display supports it, else it stays on. Errors: device, disconnected.
  Result<> turn_off();
  bool is_off() const { return open_->off; }
  void stay_on() { open_->off = open_->stays_on = false; }  // the next picture turns it on

  Stage& stage() { return open_->stage; }
  const Stage& stage() const { return open_->stage; }
  Display* display() { return open_ ? open_->display.get() : nullptr; }

 private:
  struct Open {
    std::unique_ptr<Display> display;
    Stage stage;       // its GL objects belong to the display's context
    PlaneMode planes;  // of this display and this stage
    bool dark = true;
    bool off = false;
    bool stays_on = false;  // it cannot be turned off
  };
  bool open();
  Result<PlaneMode::Attempt> show_on_planes(std::shared_ptr<const void> until_replaced);
  std::string against_planes(const SceneFrame* frame, const Composition& composition) const;
  void show_refusal(std::unique_ptr<Display> display, std::string why);
  void await_refusal();

  ContentPtr content_;
  Devices& devices_;
  Clock& clock_;
  Watchdog& watchdog_;
  DisplayStatus& status_;
  std::unique_ptr<DisplayWatch> watch_;

  std::optional<Open> open_;
  bool camera_gone_ = false;  // the GPU still holds its buffers
  struct Refused {
    std::string why;
    std::unique_ptr<Display> display;  // that shows no more than the still picture; null: not even that
    Instant until;
    bool told = false;
  };
  std::optional<Refused> refused_;
  int refusals_ = 0;                // in a row
  std::optional<SceneAir> air_;     // of the last stage, for the next one
  std::optional<Passers> passers_;  // likewise: what it learnt of the scene
  Instant try_at_;
  Instant tried_at_;
  bool missing_logged_ = false;            // that there is no display
  std::optional<Instant> timeouts_since_;  // since when begin() has had no buffer
};

}  // namespace kasumi
