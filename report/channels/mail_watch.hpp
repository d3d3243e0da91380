// Whether it is time for a mail: what has lasted is told, what flaps is told once and summed up later.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "report/diagnosis/diagnosis.hpp"

namespace kasumi::report {

// How long something must be wrong before it is told: half a minute where visitors see it, longer for what passes by itself.
// Empty: it does not say why.
Duration patience_with(std::optional<Ill> ill);
// How long it must not have been wrong before it is over. What comes back sooner has never been away.
constexpr Duration kCalm = std::chrono::minutes(5);

// Something that is wrong, or was.
struct Episode {
  std::optional<Ill> ill;  // empty: visitors do not see the building's picture, and it does not say why
  std::string detail;      // in the kiosk's own words
  Utc from{}, to{};        // when it was seen first and last
  int times = 1;           // how often it came
};

struct MailNews {
  Sight sight = Sight::unknown;
  std::vector<Episode> wrong;  // the worst first
  std::vector<Episode> over;   // since the last mail
  int more_over = 0;           // that were not kept
};

// Kept over restarts, so that a machine that restarts again and again does not write each time.
struct MailMemory {
  std::vector<std::optional<Ill>> told;  // as wrong, in the last mail
  std::optional<Utc> mailed;
  int held_back = 0;  // pauses in a row in which there was something to tell
  friend bool operator==(const MailMemory&, const MailMemory&) = default;
};
std::string text_of(const MailMemory& memory);
// What can be understood of it.
MailMemory parse_mail_memory(std::string_view text);

class MailWatch {
 public:
  // At least `pause` between mails; twice as long after each pause in which something had to wait, 16 times at most.
  MailWatch(Duration pause, MailMemory memory, Clock& clock);

  // Call it after each look at the kiosk.
  void look(const Heard& heard);
  // What should be told now, if it may be.
  std::optional<MailNews> due() const;
  // It was.
  void told(const MailNews& news);
  // The last mail could not be sent: again, but not at once.
  void failed();

  const MailMemory& memory() const { return memory_; }
  Duration pause() const;  // as long as it is now

 private:
  struct Followed {
    Episode episode;
    Instant first, last;  // seen
    bool lasted = false;
    bool there = false;  // at the last look
  };
  bool has_news() const;
  void follow(const Diagnosis& diagnosis, const Heard& heard);
  void leave_what_is_over();

  Duration pause_;
  MailMemory memory_;
  Clock& clock_;
  Sight sight_ = Sight::unknown;
  std::map<std::optional<Ill>, Followed> followed_;
  std::vector<Episode> over_;  // that lasted and ended, since the last mail
  int more_over_ = 0;
  Instant quiet_until_;
  bool waited_ = false;  // something had to, in this pause
  bool failing_ = false;
};

}  // namespace kasumi::report
