// New content has to prove itself: ten minutes of pictures and a well doctor, then it is kept. What has not within half
// an hour goes back by itself.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "pipeline/kiosk/content/arrival.hpp"
#include "pipeline/kiosk/content/generations.hpp"
#include "pipeline/site/config/content.hpp"

namespace kasumi {

struct ProbationStatus {
  std::optional<Generation> shown;      // empty: what was set up by hand
  Duration left{};                      // of pictures, until the probation ends
  std::optional<Generation> went_back;  // the newest installation, where it did
  std::optional<Arrival> arrived;       // what was brought last
  Utc told{};
};

class Probation {
 public:
  // By the doctor's name of each check that fails: what was found.
  using FailingChecks = std::map<std::string, std::string>;
  // `reload`: asks for what the place leads to, once it leads back.
  Probation(ContentPlace place, std::function<void()> reload) : place_(std::move(place)), reload_(std::move(reload)) {}

  // This content is shown from now on. Of the checks that failed before none is held against it.
  void adopt(const Content& content, Utc now);
  // What went on in the time that `passed` since the last step. BLOCKS for the seconds that reading content takes, when
  // it is to go back.
  void step(Duration passed, bool pictures, const FailingChecks& failing, Utc now);
  ProbationStatus status() const { return status_; }
  bool in_use() const { return !place_.generations.folder().empty(); }
  // Whether what is shown is a generation, for which no copies need to be kept.
  bool holds() const { return status_.shown.has_value(); }

 private:
  void prove(Utc now);
  void go_back(const std::string& why, Utc now);
  void tell(Utc now);
  std::string held_against(const FailingChecks& failing) const;

  ContentPlace place_;
  std::function<void()> reload_;
  FailingChecks failing_;  // at the last step
  std::string config_;     // the file that is shown
  Duration waited_{}, lasted_{};
  bool stuck_ = false;  // there is nothing to go back to
  std::optional<Duration> ask_again_;
  ProbationStatus status_;
};

}  // namespace kasumi
