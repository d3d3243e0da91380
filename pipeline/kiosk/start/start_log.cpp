#include "pipeline/kiosk/start/start_log.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include <spdlog/spdlog.h>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/abandonable.hpp"
#include "base/outside/json_depth.hpp"
#include "base/outside/json_text.hpp"

namespace kasumi {

namespace {

using Json = nlohmann::json;

constexpr const char* kRecordName = "starts.json";            // in the state folder
constexpr const char* kModes[] = {"whole", "safe", "plain"};  // names in starts.json, by StartMode

std::filesystem::path folder_of(const char* variable) {
  const char* value = std::getenv(variable);
  return value ? std::filesystem::path(value) : std::filesystem::path();
}

std::filesystem::path record_file(const ServiceFolders& folders) {
  return folders.state / kRecordName;
}

std::string json_text(const StartRecord& record) {
  return text_of_json(Json{{"boot", record.boot},
                           {"starts_s", record.starts_s},
                           {"doing", record.doing},
                           {"shown", record.shown},
                           {"well", record.well},
                           {"ended", record.ended},
                           {"mode", kModes[static_cast<std::size_t>(record.mode)]},
                           {"trial", record.trial},
                           {"trials", record.trials},
                           {"failed_boots", record.failed_boots},
                           {"why", record.why},
                           {"unasked", record.unasked},
                           {"hung_openings", record.hung_openings}},
                      1) +
         "\n";
}

// Damaged values are left out: a start is never refused because of them.
StartRecord record_in(const std::string& text) {
  StartRecord record;
  const auto json = parse_json(modest_json(text));
  if (!json.is_object()) return record;
  const auto read = [&](const char* key, auto is, auto& value) {
    if (json.contains(key) && (json[key].*is)()) json[key].get_to(value);
  };
  read("boot", &Json::is_string, record.boot);
  read("doing", &Json::is_string, record.doing);
  read("shown", &Json::is_boolean, record.shown);
  read("well", &Json::is_boolean, record.well);
  read("ended", &Json::is_boolean, record.ended);
  read("trial", &Json::is_boolean, record.trial);
  read("trials", &Json::is_number_unsigned, record.trials);
  read("failed_boots", &Json::is_number_unsigned, record.failed_boots);
  for (const auto& start : json.value("starts_s", Json::array()))
    if (start.is_number() && std::isfinite(start.get<double>())) record.starts_s.push_back(start.get<double>());
  for (const auto& line : json.value("why", Json::array()))
    if (line.is_string()) record.why.push_back(line.get<std::string>());
  read("unasked", &Json::is_boolean, record.unasked);
  const auto hung = json.value("hung_openings", Json::object());
  for (const auto& [camera, times] : hung.items())
    if (times.is_number_unsigned())
      record.hung_openings[camera] = static_cast<int>(std::min<std::uint64_t>(times.get<std::uint64_t>(), 1000));
  for (const auto mode : {StartMode::whole, StartMode::safe, StartMode::plain})
    if (json.value("mode", Json()) == kModes[static_cast<std::size_t>(mode)]) record.mode = mode;
  return record;
}

// A disk that answers does so in milliseconds; the start goes on without the record.
constexpr Duration kReadDeadline = std::chrono::seconds(2);
constexpr Duration kShowFirst = std::chrono::seconds(5);       // a picture, before anything is noted on the disk
constexpr Duration kCountDeadline = std::chrono::seconds(2);   // as long for writing
constexpr Duration kMemoryDeadline = std::chrono::seconds(3);  // for what takes microseconds on an idle machine

// What earlier starts left.
struct Left {
  StartRecord record;
  std::vector<std::string> never_began;  // boots, as systemd writes their ids
};

Left read_left(const ServiceFolders& folders) {
  Left left{record_in(read_text_file(record_file(folders), kSmallFile).value_or("")), {}};
  std::istringstream boots(read_text_file(folders.state / "never-began", kSmallFile).value_or(""));
  for (std::string line; std::getline(boots, line);) left.never_began.push_back(line);
  return left;
}

// Of this boot: newer than what the disk has. A start that began may let the next boot come.
std::optional<StartRecord> take_record_in_memory(const ServiceFolders& folders, const std::string& boot) {
  if (folders.runtime.empty()) return std::nullopt;
  std::error_code error;
  std::filesystem::remove(folders.runtime / "no-reboot", error);
  auto record = record_in(read_text_file(folders.runtime / kRecordName, kSmallFile).value_or(""));
  return record.boot == boot ? std::optional(std::move(record)) : std::nullopt;
}

}  // namespace

ServiceFolders service_folders() {
  return {folder_of("STATE_DIRECTORY"), folder_of("RUNTIME_DIRECTORY")};
}

StartLog::StartLog(const ServiceFolders& folders, const std::string& boot, double since_boot_s) : folders_(folders) {
  if (folders_.state.empty()) return;
  auto left = within<Left>(kReadDeadline, [folders] { return read_left(folders); });
  if (!left) spdlog::error("{}: does not answer: earlier starts are not known", folders_.state.string());
  if (!left) left.emplace();
  auto this_boot = boot;
  std::erase(this_boot, '-');
  for (const auto& line : left->never_began)
    if (line != this_boot) spdlog::warn("never began in an earlier boot: `journalctl -u kasumi -b {}` says why", line);
  const auto in_memory = within<std::optional<StartRecord>>(
      kMemoryDeadline, [folders, boot] { return take_record_in_memory(folders, boot); });
  auto record = in_memory.value_or(std::nullopt).value_or(std::move(left->record));
  failed_before_ = record.boot == boot && !record.shown && !record.ended;
  hold_until_ = SystemClock().now() + (failed_before_ ? Duration{} : kShowFirst);
  {
    const MutexLock lock(mutex_);
    record_ = std::move(record);
  }
  change([&](StartRecord& noted) { note_start(noted, boot, since_boot_s); });
  if (failed_before_) writer_.flush(kCountDeadline);
}

template <class Change>
void StartLog::change(Change apply) {
  if (folders_.state.empty()) return;
  const MutexLock lock(mutex_);
  apply(record_);
  note();
}

void StartLog::note() {
  const auto text = json_text(record_);
  if (!folders_.runtime.empty())
    note_in_memory("starts", [file = folders_.runtime / kRecordName, text] { (void)write_text_file(file, text); });
  const auto job = [folders = folders_, text, failed = write_failed_] {
    const auto written = write_text_file(record_file(folders), text);
    if (!written && !failed->exchange(true)) spdlog::warn("starts are not counted: {}", written.error().message);
    if (written) *failed = false;
    std::error_code error;
    std::filesystem::remove(folders.state / "never-began", error);
  };
  writer_.post("starts", job, held());
}

Duration StartLog::held() const {
  return released_ ? Duration{} : std::max<Duration>(hold_until_ - SystemClock().now(), Duration{});
}

void StartLog::note_too(const std::string& name, std::function<void()> job) {
  if (folders_.state.empty()) return job();
  writer_.post(name, std::move(job), held());
  if (failed_before_) writer_.flush(kCountDeadline);
}

void StartLog::note_in_memory(const std::string& name, std::function<void()> job) {
  const bool silent = !memory_.do_now(name, std::move(job), kMemoryDeadline);
  if (memory_silent_.exchange(silent) == silent) return;
  if (silent)
    spdlog::error("the folder of status.json does not answer: nothing is written there meanwhile");
  else
    spdlog::info("the folder of status.json answers again");
}

StartRecord StartLog::record() const {
  const MutexLock lock(mutex_);
  return record_;
}

void StartLog::doing(const std::string& what) {
  change([&](StartRecord& record) { record.doing = what; });
}

void StartLog::shown() {
  released_ = true;
  change([](StartRecord& record) { record.shown = true; });
}

void StartLog::well() {
  released_ = true;
  change(note_well);
  if (folders_.runtime.empty()) return;
  note_in_memory("well", [file = folders_.runtime / "starts"] {
    std::error_code error;
    std::filesystem::remove(file, error);
  });
}

void StartLog::ended() {
  change([](StartRecord& record) { record.ended = true; });
  writer_.flush(std::chrono::seconds(1));
}

void StartLog::opening_hangs(const std::string& camera) {
  change([&](StartRecord& record) { note_hung_opening(record, camera); });
  writer_.flush(std::chrono::seconds(10));
}

void StartLog::opened(const std::string& camera) {
  if (record().hung_openings.contains(camera)) change([&](StartRecord& record) { note_opened(record, camera); });
}

}  // namespace kasumi
