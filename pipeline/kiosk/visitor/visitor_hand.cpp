#include "pipeline/kiosk/visitor/visitor_hand.hpp"

#include <algorithm>
#include <cmath>

#include "pipeline/site/visitor/building_view.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kGlideBack = 1500ms;   // slow enough to be followed by the eye
constexpr Duration kGlideToBare = 400ms;  // a cut would be seen as a fault
constexpr Duration kKnobLetGo = 2s;       // nobody has turned it for so long
constexpr Duration kPressedIsSaid = 3s;   // a word or two are read in that time
constexpr double kMostNotches = 1000.0;   // of one event

double eased(double x) {
  return x * x * (3.0 - 2.0 * x);
}

}  // namespace

void VisitorHand::glide(double to, Duration lasts, Instant now) {
  glide_ = Glide{choice_.bare, to, now, lasts};
}

void VisitorHand::let_go(Instant now) {
  turned_at_.reset();
  if (held_) return glide(1.0, kGlideToBare, now);
  if (choice_.bare > 0.0) glide(0.0, kGlideBack, now);
}

void VisitorHand::press(HandKey key, Instant now) {
  pressed_ = key;
  pressed_at_ = now;
  count(key);
  switch (key) {
    case HandKey::then_and_now:
      held_ = true;
      turned_at_.reset();
      return glide(1.0, kGlideToBare, now);
    case HandKey::era: choice_.era = (choice_.era + 1) % limits_.eras; return;
    case HandKey::language: choice_.language = (choice_.language + 1) % limits_.languages; return;
    case HandKey::large_print: choice_.large_print = !choice_.large_print; return;
    case HandKey::view: choice_.view = (choice_.view + 1) % kBuildingViews; return;
    case HandKey::story: choice_.story = (choice_.story + 1) % (stories_ + 1); return;
  }
}

void VisitorHand::offer_stories(std::size_t count) {
  stories_ = count;
  if (choice_.story > count) choice_.story = 0;
}

void VisitorHand::take(const HandEvent& event, Instant now) {
  step(now);
  if (!std::isfinite(event.value)) return;
  using Kind = HandEvent::Kind;
  if (event.kind != Kind::all_up) touched_at_ = now;
  switch (event.kind) {
    case Kind::down:
      if (event.key == HandKey::then_and_now && held_) return;
      return press(event.key, now);
    case Kind::up:
      if (event.key != HandKey::then_and_now || !held_) return;
      held_ = false;
      if (!touching_) let_go(now);
      return;
    case Kind::touch:
      if (!touching_) count(HandKey::then_and_now);
      touching_ = true;
      turned_at_.reset();
      glide_.reset();
      choice_.bare = std::clamp(event.value, 0.0, 1.0);
      return;
    case Kind::touch_end:
      if (!touching_) return;
      touching_ = false;
      return let_go(now);
    case Kind::turn:
      if (touching_ || held_) return;
      if (!turned_at_) count(HandKey::then_and_now);
      turned_at_ = now;
      glide_.reset();
      choice_.bare =
          std::clamp(choice_.bare + limits_.notch * std::clamp(event.value, -kMostNotches, kMostNotches), 0.0, 1.0);
      return;
    case Kind::all_up:
      if (!held_ && !touching_) return;
      held_ = touching_ = false;
      return let_go(now);
  }
}

void VisitorHand::step(Instant now) {
  if (turned_at_ && now - *turned_at_ >= kKnobLetGo) let_go(now);
  if (touched_at_ && now - *touched_at_ >= limits_.idle) {
    // A button that is stuck, or leant on, is let go too.
    held_ = touching_ = false;
    const double bare = choice_.bare;
    choice_ = Choice{};
    choice_.bare = bare;
    touched_at_.reset();
    pressed_.reset();
    let_go(now);
  }
  if (!glide_) return;
  const double x = std::clamp(to_seconds(now - glide_->began) / to_seconds(glide_->lasts), 0.0, 1.0);
  choice_.bare = std::clamp(glide_->from + (glide_->to - glide_->from) * eased(x), 0.0, 1.0);
  if (x >= 1.0) glide_.reset();
}

std::optional<HandKey> VisitorHand::pressed(Instant now) const {
  return pressed_ && now - pressed_at_ < kPressedIsSaid ? pressed_ : std::nullopt;
}

}  // namespace kasumi
