// The status loop: writes the appliance's status and saves the air for the next start.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "history/history_keeper.hpp"
#include "history/history_minute.hpp"
#include "pipeline/kiosk/appliance/status.hpp"
#include "pipeline/kiosk/loop/hang_watch.hpp"
#include "pipeline/kiosk/start/start_log.hpp"
#include "pipeline/kiosk/visitor/visitor_presses.hpp"
#include "pipeline/machine/notifier.hpp"

namespace kasumi {

struct StatusOutputs {
  std::optional<std::filesystem::path> file;         // status.json
  bool stats = false;                                // log latency and copies every minute
  Duration save_interval = std::chrono::minutes(5);  // of the air
  StartLog* starts = nullptr;                        // null: not started by the service
  std::filesystem::path sys = "/sys";                // where the kernel says how hot it is
};

class StatusLoop {
 public:
  StatusLoop(ContentPtr content, StatusOutputs options, Clock& clock, Notifier& notifier, Mailboxes& mailboxes);
  // BLOCKS for as long as the disk takes. Call it about once a second.
  void step();
  void keep();    // writes and saves what there is
  void finish();  // the same, and the last statistics
  const Status& status() const { return status_; }

 private:
  void gather();
  void write_status();
  void save_air();
  void keep_layer();
  void keep_history(const std::optional<HistoryLine>& minute);
  void count_presses();
  void keep_presses();
  void note(const std::string& what, std::function<void()> job);

  ContentPtr content_;
  StatusOutputs options_;
  Clock& clock_;
  Notifier& notifier_;
  Mailboxes& mailboxes_;
  struct Told {  // by the other loops' reports
    CameraStatus scene_camera, sky_camera;
    SkyStatus sky;
    RenderStatus render;
  };
  CameraStatus seen_from_here(CameraStatus camera, const Pulse& loop) const;
  void watch_openings();
  void age_sky();
  void judge_render();
  void govern_heat();

  Told told_;
  bool scene_opening_told_ = false, sky_opening_told_ = false;  // that it hangs
  Status status_;
  HeatGovernor heat_;
  std::optional<Instant> heat_read_at_;
  HangWatch hangs_;  // of the render loop, which watches the others
  std::string line_;
  HistoryMinute minute_;
  struct Kept {  // owned by the writers
    HistoryKeeper history;
    // Logged.
    bool air_failing = false, history_failing = false, layer_failing = false, presses_failing = false,
         status_failing = false;
  };
  std::shared_ptr<Kept> kept_ = std::make_shared<Kept>();
  std::array<std::uint64_t, kHandKeys> presses_{};  // since the start, as last told
  PressesByHour fresh_presses_;                     // not yet kept
  Instant saved_, stats_at_, trim_at_, presses_kept_;
  bool started_ = false;  // what only the start needed has been let go
};

}  // namespace kasumi
