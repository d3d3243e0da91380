#include "pipeline/kiosk/visitor/visitor_desk.hpp"

#include <algorithm>
#include <utility>

#include "base/words/texts.hpp"

namespace kasumi {

namespace {

// Chosen: a new building is looked at for some seconds before its name is read.
constexpr Duration kEraIsSaid = std::chrono::seconds(5);
constexpr Duration kEraIsAwaited = std::chrono::seconds(20);  // then the visitor reads that it does not come
constexpr Duration kRefusalIsSaid = std::chrono::seconds(8);  // two lines are read twice
constexpr double kLargePrint = 1.6;                           // of the usual size; labels still fit on half a screen

std::vector<std::string> names_of(const std::vector<Era>& eras) {
  std::vector<std::string> names;
  for (const auto& era : eras) names.push_back(era.name);
  return names;
}

std::vector<Language> from_configured(std::vector<Language> languages, Language configured) {
  if (languages.empty()) languages = all_languages();
  const auto place = std::ranges::find(languages, configured);
  if (place == languages.end())
    languages.insert(languages.begin(), configured);
  else
    std::rotate(languages.begin(), place, languages.end());
  return languages;
}

}  // namespace

void VisitorDesk::use(const Content& content) {
  const auto& config = content.config;
  if (const auto name = era_name(content); name != shown_era_) {
    shown_era_ = name;
    era_shown_at_ = clock_.now();
  }
  content_ = content.visitor;
  auto languages =
      from_configured(config.visitor ? config.visitor->languages : std::vector<Language>{}, config.messages.language);
  const bool same_eras = names_of(config.eras) == names_of(eras_);
  eras_ = config.eras;
  time_zone_ = config.opening.time_zone;
  site_ = config.installation.site;
  hours_as_of_.reset();
  if (options_ == config.visitor && same_eras && languages == languages_) {
    if (hand_) hand_->offer_stories(stories().size());
    return;
  }
  const bool same_devices = options_ && config.visitor && options_->devices == config.visitor->devices &&
                            options_->keys == config.visitor->keys;
  options_ = config.visitor;
  languages_ = std::move(languages);
  if (!same_devices) end_links();  // before they are opened again
  hand_.reset();
  if (!options_) return;
  if (links_.empty()) begin_links();
  hand_.emplace(
      VisitorHand::Limits{std::max<std::size_t>(eras_.size(), 1), languages_.size(), options_->notch, options_->idle});
  hand_->offer_stories(stories().size());
}

void VisitorDesk::begin_links() {
  for (const auto& device : options_->devices) {
    auto one = *options_;
    one.devices = {device};
    links_.push_back(std::make_shared<InputLink>(std::move(one), clock_.now(), news_));
    devices_.serve(links_.back());
  }
}

void VisitorDesk::end_links() {
  for (const auto& link : links_) link->end();
  links_.clear();
}

void VisitorDesk::step(std::size_t refused) {
  if (!hand_) return;
  const auto now = clock_.now();
  for (const auto& link : links_)
    for (const auto& event : link->take(now)) hand_->take(event, now);
  hand_->step(now);
  follow_era(refused);
  if (!hand_->is_idle()) follow_day();
}

// The sun's day begins at another hour everywhere: looked up once an hour.
void VisitorDesk::follow_day() {
  const Utc hour = std::chrono::floor<std::chrono::hours>(clock_.utc());
  if (std::exchange(hours_as_of_, hour) == hour) return;
  for (std::size_t i = 0; i < kBuildingViews; ++i)
    hours_[i] = kasumi::hour_of(static_cast<BuildingView>(i), hour, site_, time_zone_);
}

void VisitorDesk::follow_era(std::size_t refused) {
  const auto now = clock_.now();
  if (std::exchange(asked_era_, era()) != era() || hand_->is_idle()) {
    era_asked_at_ = hand_->is_idle() ? std::nullopt : std::optional(now);
    era_given_up_.reset();
  }
  if (!era_asked_at_) return;
  const auto chosen = chosen_era();
  if (chosen == shown_era_)
    era_given_up_.reset();
  else if (!era_given_up_ &&
           (now - *era_asked_at_ >= kEraIsAwaited || (refused < eras_.size() && eras_[refused].name == chosen)))
    era_given_up_ = now;
}

Language VisitorDesk::language() const {
  return languages_[hand_ ? hand_->choice().language : 0];
}

double VisitorDesk::print() const {
  return hand_ && hand_->choice().large_print ? kLargePrint : 1.0;
}

std::vector<const Story*> VisitorDesk::stories() const {
  std::vector<const Story*> told;
  if (!content_) return told;
  for (const Story& story : content_->stories)
    if (is_told_in(story, shown_era_)) told.push_back(&story);
  return told;
}

std::string VisitorDesk::chosen_era() const {
  const auto of_the_day = era_at(eras_, time_zone_, clock_.utc());
  return of_the_day ? eras_[(*of_the_day + era()) % eras_.size()].name : shown_era_;
}

std::string VisitorDesk::title_of_era(const std::string& name) const {
  if (!content_) return name;
  const auto era = std::ranges::find(content_->eras, name, &VisitorEra::name);
  if (era == content_->eras.end()) return name;
  const auto title = era->title.find(std::string(code_of(language())));
  return title == era->title.end() ? era->title.at(content_->languages.front()) : title->second;
}

StoryView VisitorDesk::story() const {
  const auto chosen = hand_ ? hand_->choice().story : 0;
  const auto told = stories();
  if (chosen == 0 || chosen > told.size()) return {};
  const Story& story = *told[chosen - 1];
  std::string in(code_of(language()));
  if (!story.text.contains(in)) in = content_->languages.front();
  return {story.title.at(in),
          story.text.at(in),
          in,
          {options_->left_handed, options_->seated, hand_->choice().large_print, options_->pixels_per_degree}};
}

// Of languages the next one's own name: only its readers need it.
std::vector<std::string> VisitorDesk::hints() const {
  std::vector<std::string> texts;
  if (!options_ || !hand_) return texts;
  for (const HandKey key : options_->hints) switch (key) {
      case HandKey::then_and_now: texts.push_back(std::string(text_of("hint.then_and_now", language()))); break;
      case HandKey::era: texts.push_back(std::string(text_of("hint.era", language()))); break;
      case HandKey::language:
        texts.emplace_back(name_of(languages_[(hand_->choice().language + 1) % languages_.size()]));
        break;
      case HandKey::large_print: texts.push_back(std::string(text_of("hint.large_print", language()))); break;
      case HandKey::story: texts.push_back(std::string(text_of("hint.story", language()))); break;
      case HandKey::view: texts.push_back(std::string(text_of("hint.view", language()))); break;
    }
  return texts;
}

// Named while it is prepared and when it is there; else that it does not come.
std::string VisitorDesk::era_note() const {
  if (!era_asked_at_) return {};
  const auto chosen = chosen_era(), title = title_of_era(chosen);
  const auto now = clock_.now();
  if (chosen == shown_era_) return now - std::max(era_shown_at_, *era_asked_at_) < kEraIsSaid ? title : std::string();
  if (!era_given_up_) return title + " ...";
  return now - *era_given_up_ < kRefusalIsSaid ? title + "\n" + std::string(text_of("hand.era_refused", language()))
                                               : std::string();
}

std::string VisitorDesk::note() const {
  if (!hand_) return {};
  if (auto note = era_note(); !note.empty()) return note;
  const auto pressed = hand_->pressed(clock_.now());
  if (!pressed) return {};
  switch (*pressed) {
    case HandKey::then_and_now: break;  // its labels say what it does
    case HandKey::story: break;         // it is read
    case HandKey::view: {
      auto title = title_of(view(), language(), hour_of(view()));
      return title.empty() ? std::string(text_of("hand.view_live", language())) : title;
    }
    case HandKey::era: return title_of_era(shown_era_);
    case HandKey::language: return std::string(name_of(language()));
    case HandKey::large_print:
      return std::string(text_of(hand_->choice().large_print ? "hand.large_print" : "hand.normal_print", language()));
  }
  return {};
}

std::optional<VisitorStatus> VisitorDesk::status() const {
  if (!hand_) return std::nullopt;
  VisitorStatus status{{}, hand_->presses(), hand_->is_idle()};
  for (const auto& link : links_) status.devices.push_back(link->state());
  return status;
}

}  // namespace kasumi
