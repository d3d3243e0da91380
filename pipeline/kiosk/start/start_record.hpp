// The results of the service's starts, counted over boots, and the mode of the next one. Pure: no clock, no disk.
// systemd restarts a service that ends, and after kStartsBeforeReboot starts within kStartWindow_s reboots the machine
// (systemd/kasumi.service). After three failed boots another one will not help either: safe mode then shows the still
// picture, and a whole start is tried from time to time.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace kasumi {

inline constexpr int kStartsBeforeReboot = 10;      // StartLimitBurst= of the unit
inline constexpr double kStartWindow_s = 1200.0;    // StartLimitIntervalSec= of the unit
inline constexpr int kFailedBootsBeforeSafe = 3;    // then safe mode
inline constexpr int kStartsBeforeKeptContent = 5;  // failed starts, then those with the content that worked last

enum class StartMode {
  whole,  // cameras, air, building
  safe,   // still picture and words: no cameras, nothing remembered, no shader cache
  plain,  // safe mode failed as well: not even the still picture
};

struct StartRecord {
  std::string boot;              // the kernel's id of the boot of this record
  std::vector<double> starts_s;  // after that boot: of its last starts, since it last came well
  std::string doing;             // the last known activity of the last start
  bool shown = false;            // since the last start the display took pictures, or was known to be absent
  bool well = false;             // in this boot it ran for as long as proves it
  bool ended = false;            // the last start was ended on purpose
  StartMode mode = StartMode::whole;
  bool trial = false;            // the last start tried everything after safe mode
  int trials = 0;                // since it last came well
  int failed_boots = 0;          // one after the other
  std::vector<std::string> why;  // a line for each of the last failed boots, for the operator
  bool unasked = false;          // the last start followed one of the same boot that was not ended on purpose
  // Openings that hung, one after the other, by camera: the watchdog ends the program for each.
  std::map<std::string, int> hung_openings;
};

// Notes a start `since_boot_s` after the boot of that id, and says how it has to be.
StartMode note_start(StartRecord& record, const std::string& boot, double since_boot_s);
// It ran for as long as proves it. In safe mode this changes nothing but that its own starts are forgiven.
void note_well(StartRecord& record);

void note_hung_opening(StartRecord& record, const std::string& camera);
void note_opened(StartRecord& record, const std::string& camera);
// How long this start leaves the camera alone, so that the picture is not interrupted again at once: 1, 2, 4 .. 60
// minutes. 0 where a person or a boot may have mended it.
double rest_s(const StartRecord& record, const std::string& camera);

// How long safe mode lasts before everything is tried again: an hour, then 2, 4 .. 24.
double safe_for_s(const StartRecord& record);
// Whether starts with this content have failed so often in this boot that the content may be the cause.
bool suspects_content(const StartRecord& record);

}  // namespace kasumi
