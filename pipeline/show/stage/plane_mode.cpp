#include "pipeline/show/stage/plane_mode.hpp"

#include <utility>

#include <spdlog/spdlog.h>

namespace kasumi {

namespace {

constexpr int kMostLeftOut = 2;  // in a row

}  // namespace

void PlaneMode::compose(std::string why) {
  last_.reset();
  left_out_ = 0;
  if (!given_up_) state_ = std::move(why);
}

void PlaneMode::give_up(std::string why) {
  spdlog::info("display: pictures are not put onto planes of its own: {}", why);
  compose(std::move(why));
  given_up_ = true;
}

PlaneMode::Attempt PlaneMode::leave_out(std::string why) {
  if (is_on() && left_out_++ < kMostLeftOut) return {Outcome::left_out};
  compose(std::move(why));
  return {};
}

Result<PlaneMode::Attempt> PlaneMode::show(Display& display, PlaneStack picture, std::shared_ptr<const void> holder) {
  const auto number = display.show_planes(picture, holder);
  if (number) {
    if (!is_on()) spdlog::info("display: pictures are on planes of its own");
    last_ = Last{std::move(picture), std::move(holder)};
    left_out_ = 0;
    state_ = "on";
    return Attempt{Outcome::shown, *number};
  }
  const auto& why = number.error();
  if (why.kind == FaultKind::timeout) {
    compose(why.message);
    return Attempt{};
  }
  if (why.kind != FaultKind::unsupported) return fail(why);
  const auto attempt = leave_out(why.message);
  if (attempt.outcome == Outcome::compose) give_up(why.message);
  return attempt;
}

}  // namespace kasumi
