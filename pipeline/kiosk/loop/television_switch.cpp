#include "pipeline/kiosk/loop/television_switch.hpp"

#include <spdlog/spdlog.h>

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kIdleInterval = 1s;
constexpr Duration kTelevisionPause = 10s;  // it wakes, or a bus that was busy is free again
constexpr int kTelevisionTries = 4;

TelevisionPower power_for(bool on) {
  return on ? TelevisionPower::on : TelevisionPower::standby;
}

}  // namespace

TelevisionSwitch::TelevisionSwitch(std::string adapter, Devices& devices, Clock& clock)
    : devices_(devices), clock_(clock), again_(clock.now()) {
  status_.adapter = std::move(adapter);
}

void TelevisionSwitch::use(const std::string& adapter) {
  if (adapter == status_.adapter) return;
  TelevisionStatus next;
  next.adapter = adapter;
  next.wanted_on = status_.wanted_on;
  status_ = std::move(next);
  if (status_.wanted_on) begin();
}

void TelevisionSwitch::want(bool on) {
  if (status_.wanted_on == on) return;
  status_.wanted_on = on;
  begin();
}

void TelevisionSwitch::begin() {
  tries_left_ = kTelevisionTries;
  sent_ = false;
  again_ = clock_.now();
}

Instant TelevisionSwitch::step() {
  const auto now = clock_.now();
  if (status_.adapter.empty() || tries_left_ == 0) return now + kIdleInterval;
  if (now < again_) return again_;
  --tries_left_;
  again_ = now + kTelevisionPause;
  tell(switch_it());
  return again_;
}

// Sends a message and checks ten seconds later whether the television obeyed; else sends it again. Later use of the
// remote control is not overridden.
Result<> TelevisionSwitch::switch_it() {
  auto adapter = devices_.open_television(status_.adapter);
  if (!adapter) return fail(adapter.error());
  const bool on = *status_.wanted_on;
  if (sent_) {
    const auto power = ask_television(**adapter);
    if (!power) return fail(power.error());
    status_.power = *power;
    if (*power == power_for(on) || *power == TelevisionPower::unknown) {
      tries_left_ = 0;
      return {};
    }
    if (tries_left_ == 0) return fail(FaultKind::device, "it stays {} despite the message", name_of(*power));
  }
  auto sent = on ? wake_television(**adapter) : send_television_to_sleep(**adapter);
  sent_ = sent.has_value();
  return sent;
}

void TelevisionSwitch::tell(const Result<>& done) {
  const bool answered = status_.answers.value_or(true);
  status_.answers = done.has_value();
  status_.problem = done ? "" : done.error().message;
  if (!done && answered)
    spdlog::warn("television: {}: {} (the picture goes on without it)", status_.adapter, status_.problem);
  if (done && !answered) spdlog::info("television: {}: it answers again", status_.adapter);
}

}  // namespace kasumi
