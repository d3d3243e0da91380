// What visitors choose, where [visitor] allows it: their devices read, their hand followed, and what is to be seen of it.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/kiosk/visitor/visitor_hand.hpp"
#include "pipeline/machine/buttons/input_link.hpp"
#include "pipeline/machine/devices.hpp"
#include "pipeline/show/stage/stage.hpp"

namespace kasumi {

// What visitors' hands do; only how often each key was pressed is counted.
struct VisitorStatus {
  std::vector<InputDeviceState> devices;
  std::array<std::uint64_t, kHandKeys> presses{};  // since the start
  bool idle = true;
};

// Belongs to the main thread. Without [visitor] it opens nothing and changes nothing.
class VisitorDesk {
 public:
  // `devices` and `clock` must outlive it. `news` is called from any thread when step() has something to read.
  VisitorDesk(Devices& devices, Clock& clock, std::function<void()> news)
      : devices_(devices), clock_(clock), news_(std::move(news)) {}
  ~VisitorDesk() { end_links(); }
  VisitorDesk(const VisitorDesk&) = delete;
  VisitorDesk& operator=(const VisitorDesk&) = delete;
  // Other options, or other eras, begin anew; else what was chosen stays, but for a story of another era.
  void use(const Content& content);
  // Reads what has happened since. Never waits. `refused`: of the eras, the one that cannot be shown; beyond the last:
  // none.
  void step(std::size_t refused);

  bool is_there() const { return options_.has_value(); }
  bool is_moving() const { return hand_ && hand_->is_moving(); }
  double bare() const { return hand_ ? hand_->choice().bare : 0.0; }
  BuildingView view() const { return static_cast<BuildingView>(hand_ ? hand_->choice().view : 0); }
  std::string hour_of(BuildingView view) const { return hours_[static_cast<std::size_t>(view)]; }  // on the clock
  std::size_t era() const { return hand_ ? hand_->choice().era : 0; }  // so many after the one of the day
  Language language() const;
  double print() const;                    // of the letters' usual size
  std::string note() const;                // what was chosen last, for some seconds after; empty: nothing
  std::vector<std::string> hints() const;  // what each button does, as it is to be written on the picture
  StoryView story() const;  // in the visitor's language, else in the content's usual one; no text: none is read
  std::optional<VisitorStatus> status() const;

 private:
  std::vector<const Story*> stories() const;  // to be read now
  std::string chosen_era() const;
  void follow_era(std::size_t refused);
  void follow_day();
  std::string era_note() const;
  // In the visitor's language, else in the content's usual one.
  std::string title_of_era(const std::string& name) const;

  void begin_links();
  void end_links();

  Devices& devices_;
  Clock& clock_;
  std::function<void()> news_;
  std::optional<VisitorOptions> options_;
  std::vector<Era> eras_;
  std::string time_zone_;  // of their dates and hours
  Site site_;
  std::array<std::string, kBuildingViews> hours_;  // of the views of this day
  std::optional<Utc> hours_as_of_;
  std::string shown_era_;
  Instant era_shown_at_{};
  std::size_t asked_era_ = 0;                           // era() of the last step
  std::optional<Instant> era_asked_at_, era_given_up_;  // by the visitor who is there
  std::shared_ptr<const VisitorContent> content_;       // null: there is none
  std::vector<Language> languages_{Language::english};  // the configured one first
  std::vector<std::shared_ptr<InputLink>> links_;       // one for each device
  std::optional<VisitorHand> hand_;
};

}  // namespace kasumi
