#include "pipeline/stage/plane_mode.hpp"

#include <utility>

#include <spdlog/spdlog.h>

namespace kasumi {

namespace {

constexpr int kMostRefused = 3;

}  // namespace

void PlaneMode::compose(std::string why) {
  last_.reset();
  refused_ = 0;
  if (!given_up_) state_ = std::move(why);
}

void PlaneMode::give_up(std::string why) {
  spdlog::info("display: pictures are not put onto planes of its own: {}", why);
  compose(std::move(why));
  given_up_ = true;
}

Result<PlaneMode::Attempt> PlaneMode::show(Display& display, PlanePicture picture, std::shared_ptr<const void> holder) {
  const auto number = display.show_planes(picture, holder);
  if (number) {
    if (!is_on()) spdlog::info("display: pictures are on planes of its own");
    last_ = Last{std::move(picture), std::move(holder)};
    refused_ = 0;
    state_ = "on";
    return Attempt{Outcome::shown, *number};
  }
  const auto& why = number.error();
  if (why.kind == FaultKind::timeout) {
    compose(why.message);
    return Attempt{};
  }
  if (why.kind != FaultKind::unsupported) return fail(why);
  if (is_on() && ++refused_ < kMostRefused) return Attempt{Outcome::left_out};
  give_up(why.message);
  return Attempt{};
}

}  // namespace kasumi
