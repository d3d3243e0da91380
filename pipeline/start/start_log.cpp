#include "pipeline/start/start_log.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include <spdlog/spdlog.h>
#include <nlohmann/json.hpp>

#include "base/files.hpp"

namespace kasumi {

namespace {

using Json = nlohmann::json;

constexpr const char* kModes[] = {"whole", "safe", "plain"};

std::filesystem::path folder_of(const char* variable) {
  const char* value = std::getenv(variable);
  return value ? std::filesystem::path(value) : std::filesystem::path();
}

std::filesystem::path record_file(const ServiceFolders& folders) {
  return folders.state / "starts.json";
}

std::string json_text(const StartRecord& record) {
  return Json{{"boot", record.boot},
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
              {"hung_openings", record.hung_openings}}
             .dump(1, ' ', false, Json::error_handler_t::replace) +
         "\n";
}

// Damaged values are left out: a start is never refused because of them.
StartRecord record_in(const std::string& text) {
  StartRecord record;
  const auto json = Json::parse(text, nullptr, false);
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

// systemd/wait-before-start counts them, since a program that cannot be loaded counts nothing.
void forget_boots_without_this_program(const ServiceFolders& folders, std::string boot) {
  std::erase(boot, '-');  // as systemd writes it
  std::istringstream boots(read_text_file(folders.state / "never-began").value_or(""));
  for (std::string line; std::getline(boots, line);)
    if (line != boot) spdlog::warn("never began in an earlier boot: `journalctl -u kasumi -b {}` says why", line);
  std::error_code error;
  std::filesystem::remove(folders.state / "never-began", error);
  if (!folders.runtime.empty()) std::filesystem::remove(folders.runtime / "no-reboot", error);
}

}  // namespace

ServiceFolders service_folders() {
  return {folder_of("STATE_DIRECTORY"), folder_of("RUNTIME_DIRECTORY")};
}

StartLog::StartLog(const ServiceFolders& folders, const std::string& boot, double since_boot_s) : folders_(folders) {
  if (folders_.state.empty()) return;
  forget_boots_without_this_program(folders_, boot);
  record_ = record_in(read_text_file(record_file(folders_)).value_or(""));
  change([&](StartRecord& record) { note_start(record, boot, since_boot_s); });
}

template <class Change>
void StartLog::change(Change apply) {
  if (folders_.state.empty()) return;
  const std::lock_guard lock(mutex_);
  apply(record_);
  const auto written = write_text_file(record_file(folders_), json_text(record_));
  if (!written && !write_failed_) spdlog::warn("starts are not counted: {}", written.error().message);
  write_failed_ = !written;
}

StartRecord StartLog::record() const {
  const std::lock_guard lock(mutex_);
  return record_;
}

void StartLog::doing(const std::string& what) {
  change([&](StartRecord& record) { record.doing = what; });
}

void StartLog::shown() {
  change([](StartRecord& record) { record.shown = true; });
}

void StartLog::well() {
  change(note_well);
  std::error_code error;
  if (!folders_.runtime.empty()) std::filesystem::remove(folders_.runtime / "starts", error);
}

void StartLog::ended() {
  change([](StartRecord& record) { record.ended = true; });
}

void StartLog::opening_hangs(const std::string& camera) {
  change([&](StartRecord& record) { note_hung_opening(record, camera); });
}

void StartLog::opened(const std::string& camera) {
  if (record().hung_openings.contains(camera)) change([&](StartRecord& record) { note_opened(record, camera); });
}

}  // namespace kasumi
