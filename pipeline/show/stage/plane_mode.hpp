// Whether pictures go onto the display's own planes instead of through the GPU, and why not.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "gles/display/display.hpp"

namespace kasumi {

// For one display and one content.
class PlaneMode {
 public:
  enum class Outcome {
    compose,   // it must go through the GPU
    shown,     // as `number`
    left_out,  // the one before stays
  };
  struct Attempt {
    Outcome outcome = Outcome::compose;
    std::uint64_t number = 0;
  };

  // Pictures go through the GPU for now.
  void compose(std::string why);
  // The same for good.
  void give_up(std::string why);
  // This picture cannot go onto planes: once or twice in a row it is left out, since changing the way for one picture
  // would be seen; then pictures go through the GPU for now.
  Attempt leave_out(std::string why);
  // Once the display has refused a few, or the first, pictures go through the GPU for good. Errors: those of
  // Display::show().
  Result<Attempt> show(Display& display, PlaneStack picture, std::shared_ptr<const void> holder);
  // The one shown last. Requires is_on().
  Result<Attempt> show_again(Display& display) { return show(display, last_->picture, last_->holder); }

  bool is_on() const { return last_.has_value(); }
  bool given_up() const { return given_up_; }
  const std::string& state() const { return state_; }  // "on", or why not

 private:
  struct Last {
    PlaneStack picture;
    std::shared_ptr<const void> holder;
  };
  std::optional<Last> last_;  // empty: it went through the GPU
  bool given_up_ = false;
  int left_out_ = 0;  // in a row
  std::string state_ = "no picture yet";
};

}  // namespace kasumi
