#include <algorithm>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include "pipeline/log_lines.hpp"

namespace kasumi {
namespace {

constexpr double kMostAtOnce = 20.0;
constexpr double kOneMoreAfter_s = 600.0;
constexpr std::size_t kMostThings = 64;    // with bounds of their own; all others share one
constexpr std::size_t kLongestThing = 40;  // characters

std::string thing_of(std::string_view text) {
  const auto colon = text.find(": ");
  return colon == std::string_view::npos || colon > kLongestThing ? std::string() : std::string(text.substr(0, colon));
}

// How many lines about one thing are left.
struct Allowance {
  double lines = kMostAtOnce;
  Instant counted_at{};
  std::uint64_t left_out = 0;
  spdlog::level::level_enum level = spdlog::level::info;  // of the last line left out
  std::string last;

  bool take(Instant now) {
    lines = std::min(kMostAtOnce, lines + to_seconds(now - counted_at) / kOneMoreAfter_s);
    counted_at = now;
    if (lines < 1.0) return false;
    lines -= 1.0;
    return true;
  }
};

class BoundedLines final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  BoundedLines(std::shared_ptr<spdlog::sinks::sink> next, Clock& clock) : next_(std::move(next)), clock_(clock) {}

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string text(message.payload.data(), message.payload.size());
    const auto now = clock_.now();
    auto& allowance = allowance_for(thing_of(text), now);
    if (allowance.take(now)) return pass_on(message.level, text, std::exchange(allowance.left_out, 0));
    ++allowance.left_out;
    allowance.level = message.level;
    allowance.last = text;
  }

  Allowance& allowance_for(std::string thing, Instant now) {
    if (!allowances_.contains(thing) && allowances_.size() >= kMostThings) thing.clear();
    return allowances_.try_emplace(std::move(thing), Allowance{.counted_at = now, .last = {}}).first->second;
  }

  void flush_() override {
    const auto now = clock_.now();
    for (auto& [thing, allowance] : allowances_)
      if (allowance.left_out > 0 && allowance.take(now))
        pass_on(allowance.level, allowance.last, std::exchange(allowance.left_out, 0) - 1);
    next_->flush();
  }

  void pass_on(spdlog::level::level_enum level, std::string text, std::uint64_t left_out) {
    if (left_out > 0) text += fmt::format(" ({} earlier {} left out)", left_out, left_out == 1 ? "line" : "lines");
    next_->log(spdlog::details::log_msg("kasumi", level, text));
  }
  void set_pattern_(const std::string& pattern) override { next_->set_pattern(pattern); }
  void set_formatter_(std::unique_ptr<spdlog::formatter> formatter) override {
    next_->set_formatter(std::move(formatter));
  }

  std::shared_ptr<spdlog::sinks::sink> next_;
  Clock& clock_;
  std::map<std::string, Allowance> allowances_;  // by thing
};

}  // namespace

std::shared_ptr<spdlog::sinks::sink> bounded_lines(std::shared_ptr<spdlog::sinks::sink> next, Clock& clock) {
  return std::make_shared<BoundedLines>(std::move(next), clock);
}

void bound_log(Clock& clock) {
  const auto& sinks = spdlog::default_logger_raw()->sinks();
  std::vector<spdlog::sink_ptr> bounded;
  for (const auto& sink : sinks) bounded.push_back(bounded_lines(sink, clock));
  spdlog::set_default_logger(std::make_shared<spdlog::logger>("kasumi", bounded.begin(), bounded.end()));
}

}  // namespace kasumi
