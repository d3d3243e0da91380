// A display on a scripted card, on a manual clock.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/gles/display/display_helpers.hpp"
#include "tests/gles/display/kms_fake.hpp"

namespace kasumi {

// The visitor's screen and the program that draws on it.
class KmsRig : public testing::Test {
 protected:
  void SetUp() override {
    if (auto context = open_headless_context(); !context) GTEST_SKIP() << context.error().message;
  }
  Result<std::unique_ptr<Display>> open() { return open_kms_display(options_, clock_, system_); }
  void switch_on() {
    auto opened = open();
    ASSERT_TRUE(opened.has_value()) << opened.error().message;
    display_ = std::move(*opened);
  }
  Result<std::uint64_t> show(std::shared_ptr<const void> holder = nullptr) {
    if (const auto target = display_->begin(clock_.now() + std::chrono::milliseconds(50)); !target)
      return fail(target.error());
    return display_->show(std::move(holder));
  }
  // The first picture: drawn, and on the screen.
  void show_first() {
    switch_on();
    ASSERT_TRUE(show().has_value());
  }
  void see_first() {
    show_first();
    ASSERT_TRUE(display_->begin(clock_.now() + std::chrono::milliseconds(50)).has_value());
  }
  // Shows pictures until the display reports that it must be reopened, for ten seconds at most.
  Result<std::uint64_t> show_until_refused() {
    const Instant start = clock_.now();
    Result<std::uint64_t> shown = 0u;
    while ((shown || shown.error().kind == FaultKind::timeout) && clock_.now() < start + std::chrono::seconds(10))
      shown = show();
    if (shown) return fail(FaultKind::bad_input, "the display never reported a fault");
    return shown;
  }
  // Shows pictures, reopening the display as the appliance does, until one is on the screen; returns how long that
  // took. `pause` is the appliance's poll interval while there is no display.
  Duration recover(Duration pause = std::chrono::milliseconds(500)) {
    const Instant start = clock_.now();
    while (clock_.now() < start + std::chrono::seconds(60)) {
      if (!display_) {
        auto opened = open();
        if (opened)
          display_ = std::move(*opened);
        else
          clock_.advance(pause);
        continue;
      }
      const auto shown = show();
      if (!shown && shown.error().kind != FaultKind::timeout) {
        causes_.push_back(shown.error());
        display_.reset();
        continue;
      }
      (void)display_->begin(clock_.now() + std::chrono::milliseconds(50));
      for (const Flip& flip : display_->take_flips())
        if (flip.at > start) return flip.at - start;
    }
    ADD_FAILURE() << "no picture within a minute";
    return std::chrono::seconds(60);
  }

  ManualClock clock_{kNoon};
  FakeCard card_{clock_};
  std::shared_ptr<FakeSystem> system_ = std::make_shared<FakeSystem>(card_);
  KmsDisplayOptions options_;
  std::unique_ptr<Display> display_;
  std::vector<Fault> causes_;
};

}  // namespace kasumi
