#include "pipeline/kiosk/content/probation.hpp"

#include <algorithm>

#include <spdlog/spdlog.h>

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kProbation = 10min;  // of pictures
constexpr Duration kPatience = 30min;
constexpr Duration kAskAgain = 10min;  // where the content before was refused

}  // namespace

void Probation::adopt(const Content& content, Utc now) {
  if (!in_use()) return;
  const auto& config = content.files.front().path;
  if (config == config_) return;  // the same again changes nothing
  config_ = config;
  waited_ = lasted_ = {};
  stuck_ = false;
  ask_again_.reset();
  const auto generation = place_.generations.of(config);
  if (generation && generation->on_probation()) {
    spdlog::info("the content {} ({}) is on probation: ten minutes of pictures", generation->manifest.name,
                 generation->id);
    std::vector<std::string> checks;
    for (const auto& [check, found] : failing_) checks.push_back(check);
    if (!checks.empty())
      if (auto noted = place_.generations.note_failed_before(generation->id, checks); !noted)
        spdlog::warn("what failed before is not noted: {}", noted.error().message);
  }
  tell(now);
}

void Probation::step(Duration passed, bool pictures, const FailingChecks& failing, Utc now) {
  failing_ = failing;
  tell(now);
  const auto& shown = status_.shown;
  if (!shown || shown->proven) return;
  if (shown->went_back) {    // it is still shown: the content before was refused, or is being prepared
    waited_ = lasted_ = {};  // if it is tried once more
    if (!ask_again_) ask_again_ = kAskAgain;
    if ((*ask_again_ -= passed) > Duration{}) return;
    ask_again_ = kAskAgain;
    return reload_();
  }
  waited_ += passed;
  if (pictures) lasted_ += passed;
  status_.left = std::max(Duration{}, kProbation - lasted_);
  const auto against = held_against(failing);
  if (lasted_ >= kProbation && against.empty()) return prove(now);
  if (waited_ < kPatience || stuck_) return;
  go_back(
      lasted_ < kProbation
          ? fmt::format("it showed the scene camera's pictures for {:.0f} of {:.0f} minutes, which {:.0f} were to do",
                        to_seconds(lasted_) / 60, to_seconds(waited_) / 60, to_seconds(kProbation) / 60)
          : "kasumi doctor: " + against,
      now);
}

std::string Probation::held_against(const FailingChecks& failing) const {
  std::string words;
  for (const auto& [check, found] : failing)
    if (std::ranges::find(status_.shown->failed_before, check) == status_.shown->failed_before.end())
      words += fmt::format("{}{}: {}", words.empty() ? "" : "; ", check, found.substr(0, found.find('\n')));
  return words;
}

void Probation::prove(Utc now) {
  if (auto noted = place_.generations.note_proven(status_.shown->id, now); !noted) {
    spdlog::warn("the content is not noted as proven: {}", noted.error().message);
    lasted_ -= 1min;  // then again
    return;
  }
  spdlog::info("the content {} ({}) has served its probation", status_.shown->manifest.name, status_.shown->id);
  tell(now);
}

// Not to where there is nothing: a picture that was found wanting is better than none.
void Probation::go_back(const std::string& why, Utc now) {
  const auto before = place_.generations.before(status_.shown->id);
  const auto config = before ? place_.generations.config_of(*before) : place_.config;
  const auto readable = read_content(config);
  const auto name = fmt::format("the content {} ({})", status_.shown->manifest.name, status_.shown->id);
  spdlog::error("{} has not proven itself: {}", name, why);
  if (!readable) {
    stuck_ = true;
    spdlog::error("{} stays, since the content before it cannot be read: {}", name, readable.error().message);
    return;
  }
  if (auto gone = place_.generations.go_back(status_.shown->id, now, why); !gone) {
    spdlog::error("{} cannot go back: {}", name, gone.error().message);
    waited_ -= kAskAgain;
    return;
  }
  spdlog::error("{} goes back, and is not tried again: shown next is {}", name,
                before ? before->manifest.name : config.string());
  tell(now);
  reload_();
}

void Probation::tell(Utc now) {
  if (!in_use()) return;
  status_.shown = place_.generations.of(config_);
  status_.left = std::max(Duration{}, kProbation - lasted_);
  status_.told = now;
  status_.arrived = last_arrival(place_.generations.folder());
  status_.went_back.reset();
  if (auto all = place_.generations.all();
      !all.empty() && all.front().went_back && (!status_.shown || all.front().id != status_.shown->id))
    status_.went_back = std::move(all.front());
}

}  // namespace kasumi
