#include "pipeline/machine/buttons/input_link.hpp"

#include <spdlog/spdlog.h>

#include "base/outside/abandonable.hpp"

namespace kasumi {

namespace {

constexpr Duration kInputWait = std::chrono::milliseconds(20);   // contacts settle in time, and the thread ends soon
constexpr Duration kInputPause = std::chrono::milliseconds(10);  // after events: bounds what a hostile device costs

}  // namespace

InputLink::InputLink(VisitorOptions options, Instant now, std::function<void()> news)
    : options_(std::move(options)), turned_(now.time_since_epoch().count()), tell_(std::move(news)) {
  told_.path = state_.path = options_.devices.front();
}

void InputLink::turn(InputReader& reader, Instant now) {
  turned_ = now.time_since_epoch().count();
  auto events = reader.read();
  // What was not taken yet goes before.
  auto news = news_.take().value_or(News{});
  news.events.insert(news.events.end(), events.begin(), events.end());
  if (news.events.size() > kMostInputWaiting) news.events = {{HandEvent::Kind::all_up}};
  news.state = reader.devices().front();
  news_.put(std::move(news));
  if (events.empty()) return;
  const MutexLock lock(mutex_);
  if (tell_) tell_();
}

std::vector<HandEvent> InputLink::take(Instant now) {
  const Duration silent = now.time_since_epoch() - Duration(turned_);
  std::vector<HandEvent> events;
  if (auto news = news_.take()) {
    events = std::move(news->events);
    told_ = std::move(news->state);
  }
  state_ = told_;
  if (silent <= kInputDeadline) {
    if (std::exchange(hung_, false)) spdlog::info("visitor: {}: its driver answers again", state_.path.string());
    return events;
  }
  state_.up = false;
  state_.problem =
      fmt::format("{}: hung: its driver has not answered for {:.0f} s", state_.path.string(), to_seconds(silent));
  if (std::exchange(hung_, true)) return events;
  spdlog::warn("visitor: {} (the picture goes on without it)", state_.problem);
  events.push_back({HandEvent::Kind::all_up});
  return events;
}

void InputLink::end() {
  ended_ = true;
  const MutexLock lock(mutex_);
  tell_ = nullptr;
}

void serve_input(std::shared_ptr<InputLink> link, InputReader::Opener opener) {
  Abandonable<bool>([link = std::move(link), opener = std::move(opener)] {
    ::pthread_setname_np(::pthread_self(), "input");
    SystemClock clock;
    InputReader reader(link->options(), opener, clock);
    while (!link->ended()) {
      const auto began = clock.now();
      link->turn(reader, began);
      reader.wait(kInputWait);
      if (clock.now() - began < kInputPause) std::this_thread::sleep_for(kInputPause);
    }
    return true;
  });
}

}  // namespace kasumi
