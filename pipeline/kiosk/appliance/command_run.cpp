#include <malloc.h>

#include <csignal>
#include <cstdlib>
#include <memory>
#include <thread>

#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "base/outside/abandonable.hpp"
#include "base/outside/lines.hpp"
#include "base/outside/this_boot.hpp"
#include "base/utc_text.hpp"
#include "pipeline/command.hpp"
#include "pipeline/kiosk/appliance/safe_mode.hpp"
#include "pipeline/kiosk/appliance/threads.hpp"
#include "pipeline/kiosk/content/content_at_start.hpp"
#include "pipeline/kiosk/start/shader_cache.hpp"
#include "pipeline/log_lines.hpp"
#include "pipeline/machine/camera_acceptance.hpp"
#include "pipeline/machine/notifier.hpp"
#include "pipeline/machine/state_folder.hpp"
#include "pipeline/show/stage/stage_making.hpp"
#include "pipeline/show/stage/stories_on_glass.hpp"
#include "pipeline/show/stage/words_on_glass.hpp"
#include "pipeline/site/config/sighting.hpp"

namespace kasumi {

namespace {

constexpr std::chrono::seconds kContentDeadline{45};  // the unit waits for a minute
constexpr int kBadConfiguration = 78;  // EX_CONFIG: the unit does not restart it until a person has fixed the file

struct RunArguments {
  std::string config;
  std::string content;
  std::string status;
  bool stats = false;
  bool check = false;
};

std::optional<std::filesystem::path> status_file(const std::string& given) {
  if (!given.empty()) return given;
  if (const char* folder = std::getenv("RUNTIME_DIRECTORY"); folder && *folder)
    return std::filesystem::path(folder) / "status.json";
  return std::nullopt;
}

int refused(const Fault& fault) {
  if (fault.kind == FaultKind::io) {  // may pass: it is tried again
    print_error("the configuration cannot be read:\n" + fault.message);
    return EXIT_FAILURE;
  }
  print_error("the configuration is invalid:\n" + fault.message);
  return kBadConfiguration;
}

void log_sighting(const Content& content) {
  const auto sighting = sight_object(content.config.installation, content.model->bounds());
  spdlog::log(sighting.in_picture() ? spdlog::level::info : spdlog::level::warn, "{}", sighting.message);
  for (const auto& note : model_notes(content)) spdlog::info("{}", note);
  if (const auto& note = content.config.sky_model_note; !note.empty()) spdlog::warn("{}", note);
}

// Draws it once off screen, which finds content that only GL refuses.
Result<int> check_drawing(const RunArguments& arguments, const ContentPtr& content) {
  std::string renderer;
  Result<> drawn;
  for (const auto& era : all_eras(content)) {
    drawn = try_drawing(era, prepare_stage(*era), renderer);
    if (!drawn) break;
  }
  if (!drawn && renderer.empty())
    print_error(fmt::format("whether it can be drawn is not known: {}", drawn.error().message));
  if (!drawn && !renderer.empty()) {
    print_error(fmt::format("the content cannot be drawn by {}:\n{}", renderer, drawn.error().message));
    return kBadConfiguration;
  }
  fmt::print("{}: configuration is valid{}\n", arguments.config,
             drawn ? fmt::format(", and drawn by {}", renderer) : std::string());
  return 0;
}

Result<int> check(const RunArguments& arguments) {
  const auto content = read_content(arguments.config);  // what was set up by hand: a bundle was checked when packed
  if (!content) return refused(content.error());
  log_sighting(**content);
  for (const auto& fault : words_that_cannot_be_read((*content)->config)) fmt::print("{}\n", fault);
  for (const auto& fault : stories_that_cannot_be_seen(**content)) fmt::print("{}\n", fault);
  if (const auto& folder = (*content)->config.state_folder) {
    const auto remark = try_state_folder(*folder);
    if (!remark) {
      print_error(remark.error().message);
      return remark.error().kind == FaultKind::bad_input ? kBadConfiguration : EXIT_FAILURE;
    }
    if (!remark->empty()) fmt::print("{}\n", *remark);
  }
  SystemClock clock;
  std::vector<std::string> untried;
  const auto usable = try_cameras((*content)->config, *machine_devices(clock), clock, untried);
  for (const auto& remark : untried) fmt::print("{}\n", remark);
  if (!usable) {
    print_error("the content can never go live:\n" + usable.error().message);
    return kBadConfiguration;
  }
  if (const auto summary = calibration_summary((*content)->config.installation, arguments.config); !summary.empty())
    fmt::print("{}\n", summary);
  if (const auto& map = (*content)->config.installation.depth_map; !map.empty()) fmt::print("{}\n", map);
  return check_drawing(arguments, *content);
}

// What is configured or worked before, and can be drawn here as far as that can be known without the display.
Result<ContentPtr> content_that_can_be_drawn(const ContentPlace& place, StartLog& starts,
                                             const std::filesystem::path& kept_folder) {
  auto content = content_at_start(place, starts, kept_folder, SystemClock().utc());
  if (!content) return content;
  std::string renderer;
  const auto drawn = try_drawing(*content, prepare_stage(**content), renderer);
  if (drawn || renderer.empty()) return content;
  return fail(drawn.error());
}

// Runs until it is ended on purpose: content that cannot be read or drawn is replaced by earlier content that worked,
// else by the still picture and words, until there is content again.
Result<int> show(const RunArguments& arguments, const ContentPlace& place, const std::shared_ptr<StartLog>& log,
                 const std::filesystem::path& kept_folder) {
  auto& starts = *log;
  starts.doing("reading configuration and content");
  auto content = within<Result<ContentPtr>>(kContentDeadline, [place, log, kept_folder] {
                   return content_at_start(place, *log, kept_folder, SystemClock().utc());
                 }).value_or(fail(FaultKind::io, "{}: the disk does not answer", place.config.string()));
  const bool by_hand = kept_folder.empty();
  if (!content && by_hand) return refused(content.error());
  for (;;) {
    if (!content) {
      content = run_without_content(
          [&] { return place.configuration(); }, starts, status_file(arguments.status),
          lines_of(content.error().message),
          [place, log, kept_folder] { return content_that_can_be_drawn(place, *log, kept_folder); });
      if (!*content) return 0;
    }
    *content = in_its_era(*content, SystemClock().utc());
    if (const auto era = era_name(**content); !era.empty()) spdlog::info("era: {}", era);
    log_sighting(**content);
    starts.doing("opening cameras and display");
    StatusOutputs status{.file = status_file(arguments.status), .stats = arguments.stats};
    if (!by_hand) status.starts = &starts;
    const auto why = run_appliance(place, *content, std::move(status), starts, kept_folder);
    if (why.empty()) return 0;
    if (by_hand) return refused({FaultKind::bad_input, why});
    notify_systemd()->alive();  // reading other content takes a while
    content = content_instead(place, **content, kept_folder, lines_of(why), SystemClock().utc());
    if (!content) content = fail(FaultKind::bad_input, "{}", why);
  }
}

Result<int> run(const RunArguments& arguments) {
  never_wait_for_log();
  std::signal(SIGXFSZ, SIG_IGN);  // beyond a limit of its size a file cannot be written, which is no reason to end
  // Pictures go back to the kernel when they are given back. By default the bound grows with them up to 32 MiB, and each
  // thread keeps the largest it ever had.
  ::mallopt(M_MMAP_THRESHOLD, 256 << 10);
  warm_shader_cache();
  const auto folders = service_folders();
  const auto kept_folder = folders.state.empty() ? std::filesystem::path() : folders.state / "last-good";
  const ContentPlace place{arguments.config, Generations(arguments.content)};
  auto starts = std::make_shared<StartLog>(folders, boot_id(), since_boot_s());
  Result<int> code = 0;
  if (starts->mode() == StartMode::whole)
    code = show(arguments, place, starts, kept_folder);
  else if (auto ended = run_safe_mode([&] { return place.configuration(); }, *starts, status_file(arguments.status));
           !ended)
    code = fail(ended.error());
  starts.reset();
  for (int i = 0; i < 20 && abandoned_threads > 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  if (abandoned_threads == 0 || !code) return code;
  spdlog::warn("a disk does not answer: exiting without the thread that waits for it");
  spdlog::default_logger_raw()->flush();
  std::_Exit(*code);
}

}  // namespace

void add_run_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("run", "Run the kiosk: two live cameras, a display, until SIGTERM");
  auto arguments = std::make_shared<RunArguments>();
  command->add_option("--config", arguments->config, "kasumi.toml")->required();
  command->add_option("--content", arguments->content,
                      "Where `kasumi content` keeps its generations: the current one goes before --config");
  command->add_option("--status", arguments->status,
                      "Write the status to FILE every second (default: "
                      "$RUNTIME_DIRECTORY/status.json)");
  command->add_flag("--stats", arguments->stats,
                    "Log capture-to-flip latency, copies and drops every minute, and at "
                    "the end");
  command->add_flag(
      "--check", arguments->check,
      "Only read configuration and content, try the state's folder, draw it once unseen, and report every problem");
  command->callback([arguments, &action] {
    action = [arguments] { return arguments->check ? check(*arguments) : run(*arguments); };
  });
}

}  // namespace kasumi
