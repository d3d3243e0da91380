#include "pipeline/kiosk/appliance/status_loop.hpp"

#include <utility>

#include <malloc.h>

#include <spdlog/spdlog.h>

#include "base/files.hpp"
#include "base/outside/code_pages.hpp"
#include "pipeline/kiosk/start/remembered_state.hpp"
#include "pipeline/machine/heat.hpp"
#include "pipeline/show/scene/aged_report.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

// A line of figures in the journal each minute shows a leak within hours and stays readable.
constexpr Duration kStatsInterval = 1min;
// What reading the content and compiling shaders took and gave back lies in pieces between what is still in use: 23 of
// the demo's 159 MB. Code that the start alone needed is another 77 MB where GL is software, its compiler's. It goes once:
// pages in use are not asked back from a disk that may since have failed.
constexpr Duration kFirstTrim = 20s, kTrimInterval = 1min;
constexpr Duration kPressesInterval = 10min;  // a write to the disk
constexpr Duration kHeatInterval = 5s;        // a heat sink takes minutes
// An opening that takes so long hangs. The watchdog ends the program half a minute later at the earliest, and a disk may
// be slow.
constexpr Duration kOpeningHangs = 30s;

// Logs once when writing begins to fail and once when it works again.
void log_outage(const Result<>& written, bool& failing, std::string_view what) {
  if (!written && !failing) spdlog::warn("{}: {}", what, written.error().message);
  if (written && failing) spdlog::info("{}: written again", what);
  failing = !written;
}

}  // namespace

StatusLoop::StatusLoop(ContentPtr content, StatusOutputs options, Clock& clock, Notifier& notifier,
                       Mailboxes& mailboxes)
    : content_(std::move(content)),
      options_(std::move(options)),
      clock_(clock),
      notifier_(notifier),
      mailboxes_(mailboxes),
      hangs_({&mailboxes.render.pulse}),
      saved_(clock.now()),
      stats_at_(clock.now()),
      trim_at_(clock.now() + kFirstTrim),
      presses_kept_(clock.now()) {
  status_.since = clock.utc();
}

void StatusLoop::gather() {
  const auto newest = [](auto& slot, auto& to) {
    if (auto value = slot.take()) to = std::move(*value);
  };
  StatusMailbox& mailbox = *mailboxes_.status;
  newest(mailbox.content, content_);
  newest(mailbox.scene_camera, told_.scene_camera);
  newest(mailbox.sky_camera, told_.sky_camera);
  newest(mailbox.sky, told_.sky);
  newest(mailbox.render, told_.render);
  newest(mailbox.reload, status_.reload);
  newest(mailbox.check, status_.check);
  newest(mailbox.visibility, status_.visibility);
  newest(mailbox.probation, status_.probation);
  newest(mailbox.television, status_.television);
  if (options_.starts) status_.start = options_.starts->record();
  status_.instead = content_->instead;
  status_.era = era_name(*content_);
  status_.now = clock_.now();
  status_.utc = clock_.utc();
  status_.heat.spared = mailboxes_.scene.spared;
  status_.loops.clear();
  for (const Mailbox* loop : std::as_const(mailboxes_).all())
    status_.loops.push_back(
        {std::string(loop->pulse.name()), loop->pulse.silent(status_.now), loop->pulse.hung(status_.now).has_value()});
  const auto& reload = mailboxes_.reload.pulse;
  status_.loops.push_back({"reload", reload.silent(status_.now), reload.hung(status_.now).has_value()});
  if (options_.starts) {  // the disk
    const auto busy = options_.starts->writer().busy().value_or(Duration{});
    status_.loops.push_back({"state", busy, busy > kWaitingBound});
  }
  status_.scene_camera = seen_from_here(told_.scene_camera, mailboxes_.scene.pulse);
  status_.sky_camera = seen_from_here(told_.sky_camera, mailboxes_.sky.pulse);
  age_sky();
  judge_render();
}

// A camera whose loop hangs is down, whatever its last report said.
CameraStatus StatusLoop::seen_from_here(CameraStatus camera, const Pulse& loop) const {
  const auto silent = loop.hung(status_.now);
  if (!silent) return camera;
  if (camera.health.up) camera.health.down_since = status_.now - *silent;
  camera.health.up = false;
  camera.health.cause = hung_text(*silent);
  return camera;
}

// Here, since it goes to the disk. A camera whose loop hangs while it was not up hangs in its opening, or before its
// first picture.
void StatusLoop::watch_openings() {
  if (!options_.starts) return;
  const auto watch = [&](const char* camera, const CameraHealth& health, const Pulse& loop, bool& told) {
    const auto silent = loop.hung(status_.now);
    if (!silent && health.up) options_.starts->opened(camera);
    if (!silent) told = false;
    if (!silent || *silent < kOpeningHangs || health.up || std::exchange(told, true)) return;
    options_.starts->opening_hangs(camera);
  };
  watch("scene", told_.scene_camera.health, mailboxes_.scene.pulse, scene_opening_told_);
  watch("sky", told_.sky_camera.health, mailboxes_.sky.pulse, sky_opening_told_);
}

void StatusLoop::age_sky() {
  status_.sky = told_.sky;
  if (told_.sky.told == Instant{}) return;
  status_.sky.report = aged(told_.sky.report, status_.now - told_.sky.told, content_->config.installation);
  const auto silent = mailboxes_.sky.pulse.hung(status_.now);
  if (!silent) return;
  status_.sky.up = false;
  status_.sky.report.estimate.usable = false;
  status_.sky.report.estimate.reason = "no picture of the sky: " + hung_text(*silent);
}

// While it hangs, its last picture stays on the display.
void StatusLoop::judge_render() {
  status_.render = told_.render;
  hangs_.look(status_.now);
  auto& rung = status_.render.rung;
  if (mailboxes_.render.pulse.hung(status_.now) && (rung.shown == Shown::live || rung.shown == Shown::degraded))
    rung.shown = Shown::held;
}

// Here, since a sensor may be slow to answer.
void StatusLoop::govern_heat() {
  const auto now = clock_.now();
  if (heat_read_at_ && now - *heat_read_at_ < kHeatInterval) return;
  heat_read_at_ = now;
  const auto& options = content_->config.heat;
  const auto zones = read_thermal_zones(options_.sys);
  auto& heat = status_.heat;
  heat.zone.reset();
  if (const auto* zone = hottest(zones, options)) heat.zone = *zone;
  heat.throttled = is_throttled(read_throttling_bits(options_.sys).value_or(0));
  const int before = std::exchange(heat.show_one_of, heat_.step(now, zones, heat.throttled, options));
  mailboxes_.scene.show_one_of = heat.show_one_of;
  if (heat.show_one_of == before) return;
  const auto words = heat_text(heat);
  spdlog::log(heat.show_one_of > before ? spdlog::level::warn : spdlog::level::info, "heat: {}", words);
}

void StatusLoop::step() {
  mailboxes_.status->pulse.turn(clock_.now(), kComputingBound);
  govern_heat();
  gather();
  watch_openings();
  spdlog::default_logger_raw()->flush();  // writes suppressed lines whose pause is over
  write_status();
  keep_history(minute_.add(history_line(status_), status_.now));
  count_presses();
  if (status_.now - presses_kept_ >= kPressesInterval) keep_presses();
  if (status_.now - saved_ >= options_.save_interval) save_air();
  keep_layer();
  if (status_.now >= trim_at_) {
    trim_at_ = status_.now + kTrimInterval;
    ::malloc_trim(0);
    if (!std::exchange(started_, true)) let_code_go();
  }
  if (options_.stats && status_.now - stats_at_ >= kStatsInterval) {
    stats_at_ = status_.now;
    spdlog::info("{}", stats_text(status_));
  }
}

void StatusLoop::keep() {
  gather();
  keep_history(minute_.end());
  write_status();
  save_air();
  keep_layer();
  count_presses();
  keep_presses();
  if (options_.starts) options_.starts->writer().flush(1s);
}

void StatusLoop::finish() {
  keep();
  if (options_.stats) spdlog::info("{}", stats_text(status_));
}

void StatusLoop::write_status() {
  if (auto line = status_line(status_); line != line_) notifier_.status(line_ = std::move(line));
  if (!options_.file) return;
  auto write = [kept = kept_, file = *options_.file, text = status_json(status_)] {
    log_outage(write_text_file(file, text), kept->status_failing, "status");
  };
  if (options_.starts)
    options_.starts->note_in_memory("status", std::move(write));
  else
    write();
}

// In the writer's thread, since the disk may hang; without a writer, here.
void StatusLoop::note(const std::string& what, std::function<void()> job) {
  if (options_.starts)
    options_.starts->writer().post(what, std::move(job));
  else
    job();
}

void StatusLoop::keep_history(const std::optional<HistoryLine>& minute) {
  const auto& folder = content_->config.state_folder;
  if (!folder || !minute) return;
  kept_->history.add(*folder / kHistoryFile, *minute);
  note("history", [kept = kept_] { log_outage(kept->history.write(), kept->history_failing, "history"); });
}

// By a clock that is not trusted there is no hour to count them for. A choice of other options begins at zero again.
void StatusLoop::count_presses() {
  const auto& visitor = status_.render.visitor;
  const auto told = visitor ? visitor->presses : decltype(presses_){};
  const auto before = std::exchange(presses_, told);
  if (!visitor || !status_.sky.clock_trusted || told == before) return;
  auto& hour = fresh_presses_[std::chrono::floor<std::chrono::hours>(status_.utc)];
  for (std::size_t i = 0; i < kHandKeys; ++i) hour[i] += told[i] >= before[i] ? told[i] - before[i] : told[i];
}

void StatusLoop::keep_presses() {
  presses_kept_ = status_.now;
  auto fresh = std::exchange(fresh_presses_, {});
  const auto& folder = content_->config.state_folder;
  if (!folder || fresh.empty()) return;
  note("presses", [kept = kept_, fresh = std::move(fresh), file = *folder / kPressesFile, utc = status_.utc] {
    log_outage(add_presses(file, fresh, utc), kept->presses_failing, "visitors' presses");
  });
}

void StatusLoop::keep_layer() {
  auto layer = mailboxes_.status->layer.take();
  const auto& folder = content_->config.state_folder;
  if (!layer || !folder) return;
  note("layer", [kept = kept_, state = std::move(*layer), to = *folder] {
    log_outage(save(state, to), kept->layer_failing, "layer");
  });
}

void StatusLoop::save_air() {
  saved_ = status_.now;
  const auto& folder = content_->config.state_folder;
  const auto* air = status_.sky.report.seen_air();
  // What is given needs no memory. Without a trusted clock its age would be unknown after a restart.
  const auto& installation = content_->config.installation;
  if (!folder || !air || installation.surroundings.air.whole() || !status_.sky.clock_trusted) return;
  TurbidityState state = turbidity_state(air->believed.turbidity(), air->sigma_turbidity, status_.utc - air->age,
                                         installation.model_to_fit());
  state.air = status_.sky.to_remember;
  note("air", [kept = kept_, state, to = *folder] { log_outage(save(state, to), kept->air_failing, "state"); });
}

}  // namespace kasumi
