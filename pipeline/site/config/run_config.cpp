#include "pipeline/site/config/run_config.hpp"

#include <algorithm>
#include <array>
#include <charconv>

namespace kasumi {

namespace {

// The root of all, and folders that are the system's: what is kept would lie among its files, and be swept with them.
bool is_of_the_system(const std::filesystem::path& folder) {
  auto name = std::filesystem::absolute(folder).lexically_normal().string();
  if (name.size() > 1 && name.ends_with('/')) name.pop_back();
  constexpr std::string_view kWhole[] = {"/",     "/etc", "/home", "/lib", "/media", "/mnt",     "/opt",
                                         "/root", "/run", "/srv",  "/tmp", "/var",   "/var/lib", "/var/tmp"};
  constexpr std::string_view kBelow[] = {"/bin", "/boot", "/dev", "/lib64", "/proc", "/sbin", "/sys", "/usr"};
  return std::ranges::find(kWhole, name) != std::end(kWhole) || std::ranges::any_of(kBelow, [&](std::string_view of) {
           return (name + '/').starts_with(std::string(of) + '/');
         });
}

using namespace std::chrono_literals;

// Later than any clock that has never been set.
constexpr Utc kEarliest = std::chrono::sys_days{std::chrono::year{2025} / 1 / 1};

std::optional<double> optional_number(const ConfigTable& table, std::string_view key, Range range) {
  if (!table.has(key)) return std::nullopt;
  return table.number(key, range);
}

CameraRequest read_request(const ConfigTable& table, const Camera& camera) {
  CameraRequest request;
  request.width = camera.width;
  request.height = camera.height;
  if (const auto code = table.text("format", std::string("auto")); code != "auto") {
    const auto format = parse_four_cc(code);
    if (format)
      request.format = *format;
    else
      table.problem("format", fmt::format("\"auto\" or a format that is read: {}", format.error().message));
  }
  request.frames_per_second = table.number("frames_per_second", {0.0, 1000.0}, 0.0);
  request.exposure_s = optional_number(table, "exposure_s", {1e-6, 10.0});
  request.gain = optional_number(table, "gain", {0.01, 1000.0});
  request.white_balance_k = optional_number(table, "white_balance_k", {1000.0, 20000.0});
  request.lock_white_balance = table.flag("lock_white_balance", request.lock_white_balance);
  request.buffers = table.integer("buffers", {3, 16}, request.buffers);
  request.yuv_encoding = camera.yuv_encoding;
  return request;
}

// A word that decides which other keys the table has. Empty: it is missing or none of them, and the one problem.
std::string read_kind(const ConfigTable& table, std::string_view key, std::initializer_list<std::string_view> words,
                      std::optional<std::string> usual = std::nullopt) {
  auto kind = table.choice(key, words, usual);
  if (table.has(key) ? table.if_text(key) == kind : usual.has_value()) return kind;
  for (const auto& other : table.keys()) table.ignore(other);
  return {};
}

CameraOptions read_camera_options(const ConfigTable& table, const Camera& camera) {
  const auto source = read_kind(table, "source", {"v4l2", "libcamera", "replay"});
  if (source.empty()) return ReplayCamera{};
  if (source == "replay") {
    ReplayCamera replay{table.folder() / table.text("fixture")};
    std::error_code error;
    if (const auto index = replay.fixture / camera.name / "index.csv"; !std::filesystem::is_regular_file(index, error))
      table.problem("fixture", fmt::format("a fixture's folder (looked for {})", index.string()));
    return replay;
  }
  auto request = read_request(table, camera);
  // Sky frames are used once a second, so they are copied and the driver gets its buffers back at once.
  request.lend_buffers = camera.name != "sky";
  if (source == "libcamera") return LibcameraOptions{table.text("camera"), request};
  const auto device = table.text("device");
  if (!device.empty() && !device.starts_with('/'))
    table.problem("device", "a path like \"/dev/v4l/by-id/usb-...-video-index0\"");
  return V4l2Options{device, request};
}

// "auto", "1920x1080" or "1920x1080@60"
void read_mode(const ConfigTable& table, KmsDisplayOptions& options) {
  const auto mode = table.text("mode", std::string("auto"));
  if (mode == "auto") return;
  const char *at = mode.data(), *end = mode.data() + mode.size();
  const auto number = [&](auto& value) {
    const auto parsed = std::from_chars(at, end, value);
    const bool whole = parsed.ec == std::errc{};
    at = parsed.ptr;
    return whole;
  };
  const auto sign = [&](char c) { return at != end && *at == c && ++at != nullptr; };
  bool whole = number(options.width) && sign('x') && number(options.height);
  if (whole && at != end) whole = sign('@') && number(options.refresh_hz) && at == end;
  const bool sane = options.width >= 16 && options.width <= 16384 && options.height >= 16 && options.height <= 16384 &&
                    options.refresh_hz >= 0.0 && options.refresh_hz <= 1000.0;
  if (!whole || !sane) table.problem("mode", R"("auto", "1920x1080" or "1920x1080@60")");
}

Mixing read_mixing(const ConfigTable& table) {
  const auto who = table.choice("mixing", {"auto", "gpu", "processor"}, std::string("auto"));
  if (who == "gpu") return Mixing::gpu;
  return who == "processor" ? Mixing::processor : Mixing::automatic;
}

DisplayOptions read_display(const ConfigTable& table) {
  constexpr Range kSize_px{16, 16384};
  const auto kind = read_kind(table, "kind", {"kms", "window", "headless"}, std::string("kms"));
  if (kind.empty()) return HeadlessDisplayOptions{};
  if (kind == "window") {
    WindowDisplayOptions window;
    window.width = table.integer("width", kSize_px, window.width);
    window.height = table.integer("height", kSize_px, window.height);
    return window;
  }
  if (kind == "headless") {
    HeadlessDisplayOptions headless;
    headless.width = table.integer("width", kSize_px, headless.width);
    headless.height = table.integer("height", kSize_px, headless.height);
    return headless;
  }
  KmsDisplayOptions kms;
  kms.device = table.text("device", std::string());
  kms.connector = table.text("connector", std::string());
  read_mode(table, kms);
  kms.preferred_instead = true;  // a picture of another size is better than none
  kms.atomic = table.flag("atomic", true);
  return kms;
}

ClockRules read_clock(const ConfigTable& table) {
  ClockRules clock;
  const auto policy = table.choice("policy", {"synchronized", "trusted", "from_sky"}, std::string("synchronized"));
  clock.policy = policy == "trusted"    ? ClockPolicy::trusted
                 : policy == "from_sky" ? ClockPolicy::from_sky
                                        : ClockPolicy::synchronized;
  clock.earliest = table.has("earliest_utc") ? table.utc("earliest_utc") : kEarliest;
  return clock;
}

OpeningHours read_opening(const ConfigTable& table, bool zone_matters) {
  constexpr std::array kDays{"sunday", "monday", "tuesday", "wednesday", "thursday", "friday", "saturday"};
  OpeningHours opening;
  // Hours that cannot be parsed are a problem and count as the default.
  const auto hours = [&](const char* key, const DayHours& otherwise) {
    const auto text = table.text(key, std::string());
    if (text.empty()) return otherwise;
    const auto parsed = parse_hours(text);
    if (!parsed) table.problem(key, parsed.error().message);
    return parsed.value_or(otherwise);
  };
  const auto every_day = hours("every_day", kAllDay);
  for (std::size_t day = 0; day < kDays.size(); ++day) opening.week[day] = hours(kDays[day], every_day);
  if (auto exceptions = parse_exceptions(table.text("exceptions", std::string())))
    opening.exceptions = std::move(*exceptions);
  else
    table.problem("exceptions", exceptions.error().message);

  opening.time_zone = table.text("time_zone", std::string());
  if (!opening.time_zone.empty()) {
    if (!is_time_zone(opening.time_zone))
      table.problem("time_zone", "a time zone's name like \"Europe/Zurich\" (timedatectl list-timezones)");
  } else if (zone_matters || !opening.is_always_open()) {
    if (auto zone = machine_time_zone())
      opening.time_zone = std::move(*zone);
    else
      table.problem("time_zone",
                    fmt::format("a name like \"Europe/Zurich\", since the machine has none: {}", zone.error().message));
  }
  return opening;
}

CheckSchedule read_check(const ConfigTable& table, const OpeningHours& opening) {
  constexpr Range kMinutes{0.1, 240.0};
  CheckSchedule options;
  const auto time = table.text("time", std::string("13:00"));
  const double length_min = table.number("minutes", kMinutes, 30.0);
  if (time == "never") return options;
  const auto rest_of_day = parse_hours(time + "-24:00");
  if (!rest_of_day || rest_of_day->size() != 1) {
    table.problem("time", R"(a time of the day like "13:00", by the wall clock, or "never")");
    return options;
  }
  options.length = from_seconds(60.0 * length_min);
  OpeningHours hours;
  hours.time_zone = opening.time_zone.empty() ? machine_time_zone().value_or("") : opening.time_zone;
  const auto from = rest_of_day->front().from;
  hours.week.fill({{from, from + std::chrono::ceil<std::chrono::minutes>(options.length)}});
  options.hours = std::move(hours);
  return options;
}

LadderTimes read_ladder(const ConfigTable& table) {
  LadderTimes ladder;
  const auto seconds = [&](std::string_view key, Range range, Duration fallback) {
    return from_seconds(table.number(key, range, to_seconds(fallback)));
  };
  ladder.fade = seconds("fade_s", {0.05, 5.0}, ladder.fade);
  ladder.held = seconds("held_s", {0.5, 600.0}, ladder.held);
  ladder.late = seconds("late_s", {0.05, 600.0}, ladder.late);
  ladder.steady = seconds("steady_s", {0.0, 60.0}, ladder.steady);
  if (ladder.held < ladder.fade + 100ms)
    table.problem("held_s", fmt::format("at least 0.1 s more than fade_s ({} s)", to_seconds(ladder.fade)));
  return ladder;
}

HeatLimits read_heat(const ConfigTable& table) {
  constexpr Range kCelsius{20.0, 120.0};
  HeatLimits heat;
  heat.fewer_pictures = table.flag("fewer_pictures", heat.fewer_pictures);
  heat.warm_celsius = optional_number(table, "warm_celsius", kCelsius);
  heat.hot_celsius = optional_number(table, "hot_celsius", kCelsius);
  heat.hysteresis_celsius = table.number("hysteresis_celsius", {0.5, 30.0}, heat.hysteresis_celsius);
  heat.hold = from_seconds(table.number("hold_s", {1.0, 3600.0}, to_seconds(heat.hold)));
  if (heat.warm_celsius && heat.hot_celsius && *heat.hot_celsius <= *heat.warm_celsius)
    table.problem("hot_celsius", fmt::format("more than warm_celsius ({})", *heat.warm_celsius));
  return heat;
}

// A missing optional table is read as an empty one.
template <class Read>
auto section(const ConfigTable& root, std::string_view key, Read read) {
  const auto table = root.optional_table(key);
  return read(table ? *table : *ConfigTable::parse("", root.path()));
}

}  // namespace

void read_screen(const ConfigTable& root, RunConfig& config) {
  config.display = section(root, "display", read_display);
  config.still = section(root, "still", [](const ConfigTable& table) {
    return StillContent{table.optional_file("picture"), table.text("caption", std::string())};
  });
  config.messages = section(root, "words", [](const ConfigTable& table) {
    MessageStyle options;
    const auto language = parse_language(table.text("language", std::string("en")));
    if (language)
      options.language = *language;
    else
      table.problem("language", language.error().message);
    options.font_file = table.optional_file("font_file");
    options.show_faults = table.flag("show_faults", true);
    return options;
  });
  config.snapshot = section(root, "snapshot", [](const ConfigTable& table) {
    return SnapshotPermission{table.flag("sharp", false), table.flag("screen_picture", false)};
  });
}

RunConfig read_run_config(const ConfigTable& root) {
  RunConfig config;
  config.installation = read_installation(root);
  if (auto& model = config.installation.surroundings.sky_model; model == DaylightModel::preetham) {
    model = DaylightModel::automatic;
    config.sky_model_note =
        "[site] sky_model = \"preetham\": the papers' way is for photographs and replays; a kiosk follows "
        "\"automatic\", "
        "which weighs Preetham's sky among the others";
  }
  config.sky_camera = read_camera_options(root.table("sky").table("camera"), config.installation.sky);
  config.scene_camera = read_camera_options(root.table("scene").table("camera"), config.installation.scene);
  read_screen(root, config);
  config.planes = section(root, "display", [](const ConfigTable& table) {
    return table.choice("planes", {"auto", "off"}, std::string("auto")) == "auto";
  });
  config.mixing = section(root, "display", read_mixing);
  config.overlay = section(root, "display", [](const ConfigTable& table) { return table.flag("overlay", false); });
  config.cec = section(root, "display", [](const ConfigTable& table) {
    const auto adapter = table.text("cec", std::string("off"));
    if (adapter == "off") return std::string();
    if (!adapter.starts_with('/')) table.problem("cec", R"("off" or an adapter like "/dev/cec0")");
    return adapter;
  });
  config.clock = section(root, "clock", read_clock);
  const bool has_eras = !root.tables("era").empty();
  config.opening = section(root, "opening", [&](const ConfigTable& table) { return read_opening(table, has_eras); });
  config.wake_before = section(root, "opening", [](const ConfigTable& table) {
    return from_seconds(60.0 * table.number("wake_before_min", {0.0, 240.0}, 0.0));
  });
  config.eras = read_eras(root, config.opening);
  config.visitor_content = root.optional_file("content");
  config.check = section(root, "check", [&](const ConfigTable& table) { return read_check(table, config.opening); });
  config.ladder = section(root, "ladder", read_ladder);
  config.heat = section(root, "heat", read_heat);
  config.visitor = read_visitor(root);
  config.state_folder = section(root, "state", [](const ConfigTable& table) -> std::optional<std::filesystem::path> {
    const auto folder = table.text("folder", std::string());
    if (folder.empty()) return std::nullopt;
    const auto place = table.folder() / folder;
    if (is_of_the_system(place)) table.problem("folder", "a folder of its own, such as \"/var/lib/kasumi\"");
    return place;
  });
  return config;
}

}  // namespace kasumi
