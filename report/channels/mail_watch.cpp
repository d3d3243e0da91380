#include "report/channels/mail_watch.hpp"

#include <algorithm>
#include <charconv>

#include "base/utc_text.hpp"
#include "report/diagnosis/symptom_words.hpp"

namespace kasumi::report {

namespace {

using namespace std::chrono_literals;

constexpr std::size_t kMostOver = 24;
constexpr int kMostDoublings = 4;
constexpr Duration kTryAgain = 5min;
constexpr std::string_view kNoReason = "no-reason";

std::optional<Ill> ill_named(std::string_view name) {
  for (const Ill ill : kAllIlls)
    if (name_of(ill) == name) return ill;
  return std::nullopt;
}

std::string_view name_of_cause(const std::optional<Ill>& ill) {
  return ill ? name_of(*ill) : kNoReason;
}

}  // namespace

Duration patience_with(std::optional<Ill> ill) {
  constexpr Duration kShort = 45s;
  if (!ill) return kShort;
  switch (*ill) {
    case Ill::starting:
    case Ill::clock_unset: return 3min;
    // By night nobody sees the air.
    case Ill::air_supposed:
    case Ill::observers_disagree: return 24h;
    case Ill::sky_lost:
    case Ill::hot:
    case Ill::hung: return 10min;
    default: return kShort;
  }
}

std::string text_of(const MailMemory& memory) {
  auto text = fmt::format("held_back {}\n", memory.held_back);
  if (memory.mailed) text += fmt::format("mailed {}\n", utc_text(*memory.mailed));
  for (const auto& ill : memory.told) text += fmt::format("told {}\n", name_of_cause(ill));
  return text;
}

MailMemory parse_mail_memory(std::string_view text) {
  MailMemory memory;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const auto space = std::min(line.find(' '), line.size());
    const auto key = line.substr(0, space), value = line.substr(std::min(space + 1, line.size()));
    if (key == "held_back") {
      int number = 0;
      std::from_chars(value.data(), value.data() + value.size(), number);
      memory.held_back = std::clamp(number, 0, kMostDoublings);
    } else if (key == "mailed") {
      memory.mailed = parse_utc(value);
    } else if (key == "told") {
      const auto ill = ill_named(value);
      const bool known = ill || value == kNoReason;
      if (known && std::ranges::find(memory.told, ill) == memory.told.end()) memory.told.push_back(ill);
    }
  }
  return memory;
}

MailWatch::MailWatch(Duration pause, MailMemory memory, Clock& clock)
    : pause_(pause), memory_(std::move(memory)), clock_(clock) {
  const auto now = clock_.now();
  quiet_until_ = now;
  if (!memory_.mailed) return;
  const auto utc = clock_.utc();
  // A clock that was set back, or has none of the time yet, does not make the pause longer.
  quiet_until_ += std::clamp<Duration>(*memory_.mailed + this->pause() - utc, 0s, this->pause());
  for (const auto& ill : memory_.told)
    followed_[ill] = {{ill, {}, std::min(*memory_.mailed, utc), utc, 1}, now, now, true, true};
}

Duration MailWatch::pause() const {
  return pause_ * (1 << memory_.held_back);
}

void MailWatch::look(const Heard& heard) {
  const auto diagnosis = diagnose(heard);
  sight_ = diagnosis.sight;
  follow(diagnosis, heard);
  leave_what_is_over();
  if (clock_.now() < quiet_until_ && !failing_ && has_news()) waited_ = true;
}

void MailWatch::follow(const Diagnosis& diagnosis, const Heard& heard) {
  const auto now = clock_.now();
  const auto utc = clock_.utc();
  auto symptoms = diagnosis.symptoms;
  std::map<std::optional<Ill>, std::string> seen;
  for (auto& symptom : symptoms) seen.emplace(symptom.ill, detail_text(symptom, Language::english));
  const auto trouble = heard.status ? heard.status->trouble : std::nullopt;
  const bool explained =
      diagnosis.sight == Sight::stopped || (trouble && *trouble != Trouble::none && *trouble != Trouble::closed) ||
      std::ranges::any_of(diagnosis.symptoms, [](const Symptom& symptom) { return hides_the_picture(symptom.ill); });
  if (!is_well(diagnosis.sight) && !explained)
    seen.emplace(std::nullopt, heard.status ? heard.status->reason : std::string());
  for (auto& [ill, followed] : followed_)
    if (!seen.contains(ill)) followed.there = false;
  for (auto& [ill, detail] : seen) {
    const auto [entry, is_new] = followed_.try_emplace(ill, Followed{{ill, {}, utc, utc, 1}, now, now, false, true});
    auto& followed = entry->second;
    if (!is_new && !followed.there) ++followed.episode.times;
    followed.there = true;
    followed.last = now;
    followed.episode.to = utc;
    followed.episode.detail = std::move(detail);
    if (now - followed.first >= patience_with(ill)) followed.lasted = true;
  }
}

void MailWatch::leave_what_is_over() {
  const auto now = clock_.now();
  std::erase_if(followed_, [&](const auto& entry) {
    const auto& followed = entry.second;
    if (followed.there || now - followed.last < kCalm) return false;
    if (!followed.lasted) return true;
    if (over_.size() < kMostOver)
      over_.push_back(followed.episode);
    else
      ++more_over_;
    return true;
  });
}

bool MailWatch::has_news() const {
  if (!over_.empty()) return true;
  return std::ranges::any_of(followed_, [&](const auto& entry) {
    return entry.second.lasted && std::ranges::find(memory_.told, entry.first) == memory_.told.end();
  });
}

std::optional<MailNews> MailWatch::due() const {
  if (clock_.now() < quiet_until_ || !has_news()) return std::nullopt;
  MailNews news{sight_, {}, over_, more_over_};
  for (const auto& [ill, followed] : followed_)
    if (followed.lasted) news.wrong.push_back(followed.episode);
  std::ranges::stable_sort(news.wrong, [](const Episode& a, const Episode& b) {
    return (!a.ill || hides_the_picture(*a.ill)) && b.ill && !hides_the_picture(*b.ill);
  });
  return news;
}

void MailWatch::told(const MailNews& news) {
  memory_.told.clear();
  for (const auto& episode : news.wrong) memory_.told.push_back(episode.ill);
  memory_.mailed = clock_.utc();
  memory_.held_back = waited_ ? std::min(memory_.held_back + 1, kMostDoublings) : 0;
  waited_ = failing_ = false;
  over_.erase(over_.begin(), over_.begin() + static_cast<std::ptrdiff_t>(news.over.size()));
  more_over_ -= news.more_over;
  quiet_until_ = clock_.now() + pause();
}

void MailWatch::failed() {
  failing_ = true;
  quiet_until_ = clock_.now() + kTryAgain;
}

}  // namespace kasumi::report
