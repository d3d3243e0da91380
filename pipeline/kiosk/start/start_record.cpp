#include "pipeline/kiosk/start/start_record.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

namespace kasumi {

namespace {

// How long safe mode lasts, and a camera whose opening hung is left alone: doubled with each repetition from the first
// to the longest, so that a passing fault is soon over and a lasting one is seldom tried.
constexpr double kFirstSafe_s = 3600.0, kLongestSafe_s = 24 * 3600.0;
constexpr double kFirstRest_s = 60.0, kLongestRest_s = 3600.0;
constexpr std::size_t kMostReasons = 3;  // of the newest failed starts, which fit a line of the status

bool reached_start_limit(const StartRecord& record) {
  const auto& starts = record.starts_s;
  return starts.size() >= kStartsBeforeReboot &&
         starts.back() - starts[starts.size() - kStartsBeforeReboot] <= kStartWindow_s;
}

// A power cut while visitors saw a picture is no failure. Starts that end before they are noted are not counted, so a
// crash loop need not reach the limit here, although it has for systemd.
bool has_failed(const StartRecord& record) {
  return !record.boot.empty() && !record.ended && !record.well && (reached_start_limit(record) || !record.shown);
}

std::string reason(const StartRecord& record) {
  const auto starts = record.starts_s.size();
  const auto last = record.doing.empty() ? "starting" : record.doing.c_str();
  if (reached_start_limit(record))
    return fmt::format("{} starts failed within {:.0f} minutes, the last one while {}", starts,
                       std::ceil((record.starts_s.back() - record.starts_s.front()) / 60.0), last);
  return fmt::format("ended without a picture at start {}, while {}", starts, last);
}

void begin_boot(StartRecord& record, const std::string& boot) {
  if (has_failed(record)) {
    ++record.failed_boots;
    record.why.push_back(reason(record));
    if (record.why.size() > kMostReasons) record.why.erase(record.why.begin());
  }
  record.boot = boot;
  record.starts_s.clear();
}

}  // namespace

StartMode note_start(StartRecord& record, const std::string& boot, double since_boot_s) {
  record.unasked = record.boot == boot && !record.ended;
  if (record.boot != boot) begin_boot(record, boot);
  record.starts_s.push_back(since_boot_s);
  if (record.starts_s.size() > kStartsBeforeReboot) record.starts_s.erase(record.starts_s.begin());
  // An end of safe mode, or of a trial after it, was asked for: by a person, or by safe mode whose time was up.
  const bool asked_for = record.ended && (record.mode != StartMode::whole || record.trial);
  record.doing = "starting";
  record.ended = record.well = record.shown = false;
  if (record.failed_boots < kFailedBootsBeforeSafe)
    record.mode = StartMode::whole;
  else if (asked_for)
    record.mode = StartMode::whole;
  else
    record.mode = record.failed_boots == kFailedBootsBeforeSafe ? StartMode::safe : StartMode::plain;
  record.trial = record.mode == StartMode::whole && record.failed_boots >= kFailedBootsBeforeSafe;
  if (record.trial) ++record.trials;
  return record.mode;
}

void note_well(StartRecord& record) {
  record.starts_s.clear();
  record.well = true;
  if (record.mode != StartMode::whole) return;
  record.failed_boots = record.trials = 0;
  record.trial = false;
  record.why.clear();
}

void note_hung_opening(StartRecord& record, const std::string& camera) {
  ++record.hung_openings[camera];
}

void note_opened(StartRecord& record, const std::string& camera) {
  record.hung_openings.erase(camera);
}

double rest_s(const StartRecord& record, const std::string& camera) {
  const auto hung = record.hung_openings.find(camera);
  if (!record.unasked || hung == record.hung_openings.end() || hung->second < 1) return 0.0;
  return std::min(kLongestRest_s, std::ldexp(kFirstRest_s, std::min(hung->second - 1, 10)));
}

double safe_for_s(const StartRecord& record) {
  return std::min(kLongestSafe_s, std::ldexp(kFirstSafe_s, std::min(record.trials, 10)));
}

bool suspects_content(const StartRecord& record) {
  const auto add = [](std::size_t sum, const auto& hung) { return sum + static_cast<std::size_t>(hung.second); };
  const auto& hung = record.hung_openings;
  const auto of_cameras = std::accumulate(hung.begin(), hung.end(), std::size_t{0}, add);
  return record.mode == StartMode::whole && record.starts_s.size() > kStartsBeforeKeptContent + of_cameras;
}

}  // namespace kasumi
