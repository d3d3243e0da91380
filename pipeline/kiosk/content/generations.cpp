#include "pipeline/kiosk/content/generations.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <thread>

#include <fcntl.h>
#include <sys/file.h>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/lasting_file.hpp"
#include "base/outside/json_depth.hpp"
#include "base/outside/json_text.hpp"
#include "base/unfinished_file.hpp"
#include "base/unique_fd.hpp"
#include "base/utc_text.hpp"

namespace kasumi {

namespace {

namespace fs = std::filesystem;
using RecordJson = nlohmann::ordered_json;
using namespace std::chrono_literals;

constexpr std::size_t kIdDigits = 16, kKept = 3;
constexpr const char* kHidden = ".unpack.";
constexpr auto kLongestLock = 5s;

bool is_id(std::string_view name) {
  return name.size() == kIdDigits &&
         std::ranges::all_of(name, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

// Held while records and the link change.
Result<UniqueFd> locked(const fs::path& folder) {
  if (auto made = create_folders(folder); !made) return fail(made.error());
  UniqueFd fd(::open((folder / ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644));
  if (!fd) return fail(FaultKind::io, "{}: cannot be written: {}", folder.string(), std::strerror(errno));
  for (const auto until = std::chrono::steady_clock::now() + kLongestLock;; std::this_thread::sleep_for(10ms)) {
    if (::flock(fd.value(), LOCK_EX | LOCK_NB) == 0) return fd;
    if (std::chrono::steady_clock::now() > until)
      return fail(FaultKind::io, "{}: another program has held it for {} s", folder.string(), kLongestLock.count());
  }
}

std::optional<Utc> utc_in(const RecordJson& json, const char* key) {
  if (!json.is_object() || !json.contains(key) || !json[key].is_string()) return std::nullopt;
  return parse_utc(json[key].get<std::string>());
}

std::string words_in(const RecordJson& json, const char* key) {
  return json.is_object() && json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : std::string();
}

void read_record(const std::string& text, Generation& generation) {
  const auto json = parse_ordered_json(modest_json(text));
  generation.installed = utc_in(json, "installed_utc").value_or(Utc{});
  generation.signed_by = words_in(json, "signed_by");
  generation.proven = utc_in(json, "proven_utc");
  if (const auto utc = utc_in(json, "went_back_utc")) generation.went_back = WentBack{*utc, words_in(json, "why")};
  if (!json.is_object()) return;
  if (json.contains("starts") && json["starts"].is_number_unsigned())
    generation.starts = static_cast<int>(std::min<std::uint64_t>(json["starts"].get<std::uint64_t>(), 1000));
  if (json.contains("failed_before") && json["failed_before"].is_array())
    for (const auto& check : json["failed_before"])
      if (check.is_string()) generation.failed_before.push_back(check.get<std::string>());
}

std::string record_text(const Generation& generation) {
  const auto utc = [](const std::optional<Utc>& at) {
    return at ? RecordJson(utc_text(std::chrono::floor<std::chrono::seconds>(*at))) : RecordJson(nullptr);
  };
  const auto& back = generation.went_back;
  return text_of_json(RecordJson{{"installed_utc", utc(generation.installed)},
                                 {"signed_by", generation.signed_by},
                                 {"failed_before", generation.failed_before},
                                 {"starts", generation.starts},
                                 {"proven_utc", utc(generation.proven)},
                                 {"went_back_utc", utc(back ? std::optional(back->utc) : std::nullopt)},
                                 {"why", back ? back->why : std::string()}},
                      1) +
         "\n";
}

// Of a process that has gone.
bool is_left_over(const std::string& name) {
  if (!name.starts_with(kHidden)) return false;
  pid_t writer = 0;
  const char* end = name.data() + name.size();
  const auto [rest, error] = std::from_chars(name.data() + std::strlen(kHidden), end, writer);
  return error != std::errc() || rest != end || writer == ::getpid() || (::kill(writer, 0) != 0 && errno == ESRCH);
}

fs::path hidden_folder(const fs::path& folder) {
  return folder / fmt::format("{}{}", kHidden, ::getpid());
}

}  // namespace

std::optional<Generation> Generations::read(const std::string& id) const {
  if (!is_id(id)) return std::nullopt;
  const auto text = read_text_file(folder_ / id / kManifestName, {.most_bytes = kMostManifestBytes});
  auto manifest = text ? parse_manifest(*text) : fail(text.error());
  if (!manifest) return std::nullopt;
  Generation generation;
  generation.id = id;
  generation.manifest = std::move(*manifest);
  read_record(read_text_file(folder_ / (id + ".json"), kSmallFile).value_or(""), generation);
  return generation;
}

std::vector<Generation> Generations::all() const {
  std::vector<Generation> found;
  std::error_code error;
  if (folder_.empty()) return found;
  for (auto entry = fs::directory_iterator(folder_, error); !error && entry != end(entry); entry.increment(error))
    if (auto generation = read(entry->path().filename().string())) found.push_back(std::move(*generation));
  std::ranges::sort(found, [](const Generation& a, const Generation& b) {
    return a.installed != b.installed ? a.installed > b.installed : a.id < b.id;
  });
  return found;
}

std::string Generations::current_id() const {
  std::error_code error;
  return folder_.empty() ? std::string() : fs::read_symlink(folder_ / "current", error).string();
}

std::optional<Generation> Generations::current() const {
  const auto id = current_id();
  auto generation = read(id);
  return generation || id.empty() ? generation : before(id);
}

std::optional<Generation> Generations::of(const fs::path& config_file) const {
  const auto place = config_file.parent_path();
  if (folder_.empty() || place.parent_path() != folder_) return std::nullopt;
  return read(place.filename().string());
}

fs::path Generations::config_of(const Generation& generation) const {
  return folder_of(generation) / generation.manifest.configuration;
}

Result<Generation> Generations::find(std::string_view digits) const {
  std::vector<Generation> fit;
  for (auto& generation : all())
    if (generation.id.starts_with(digits)) fit.push_back(std::move(generation));
  if (fit.size() == 1) return std::move(fit.front());
  return fail(FaultKind::bad_input, "{}: {} in {} begins with \"{}\": kasumi content list", digits,
              fit.empty() ? "no generation" : "more than one generation", folder_.string(), digits);
}

std::optional<Generation> Generations::before(const std::string& id) const {
  std::optional<Generation> best;
  for (auto& generation : all())
    if (generation.id != id && generation.proven && !generation.went_back &&
        (!best || *generation.proven > *best->proven))
      best = std::move(generation);
  return best;
}

Result<fs::path> Generations::new_folder() const {
  const auto lock = locked(folder_);
  if (!lock) return fail(lock.error());
  std::error_code error;
  std::vector<fs::path> left;
  for (auto entry = fs::directory_iterator(folder_, error); !error && entry != end(entry); entry.increment(error))
    if (is_left_over(entry->path().filename().string())) left.push_back(entry->path());
  for (const auto& each : left) fs::remove_all(each, error);
  const auto made = hidden_folder(folder_);
  if (auto created = create_folders(made); !created) return fail(created.error());
  return made;
}

Result<> Generations::add(const fs::path& unpacked, const Generation& generation) const {
  const auto lock = locked(folder_);
  if (!lock) return fail(lock.error());
  if (auto noted = note(generation); !noted) return noted;
  if (::rename(unpacked.c_str(), folder_of(generation).c_str()) != 0)
    return fail(FaultKind::io, "{}: cannot be written: {}", folder_of(generation).string(), std::strerror(errno));
  return write_through_names(folder_);
}

Result<> Generations::note(const Generation& generation) const {
  return write_text_file(folder_ / (generation.id + ".json"), record_text(generation));
}

template <class Change>
Result<> Generations::change(const std::string& id, Change change) const {
  const auto lock = locked(folder_);
  if (!lock) return fail(lock.error());
  auto generation = read(id);
  if (!generation) return fail(FaultKind::bad_input, "{}: there is no such generation", (folder_ / id).string());
  change(*generation);
  return note(*generation);
}

Result<> Generations::link_to(const std::string& id) const {
  const auto link = folder_ / "current", made = folder_ / ".current";
  std::error_code error;
  if (id.empty()) {
    fs::remove(link, error);
    if (error) return fail(FaultKind::io, "{}: cannot be removed: {}", link.string(), error.message());
    return write_through_names(folder_);
  }
  fs::remove(made, error);
  if (::symlink(id.c_str(), made.c_str()) != 0 || ::rename(made.c_str(), link.c_str()) != 0)
    return fail(FaultKind::io, "{}: cannot be written: {}", link.string(), std::strerror(errno));
  return write_through_names(folder_);
}

Result<> Generations::show(const std::string* id) const {
  if (id) {
    auto begun = change(*id, [](Generation& generation) {
      generation.went_back.reset();
      if (!generation.proven) generation.starts = 0;
    });
    if (!begun) return begun;
  }
  const auto lock = locked(folder_);
  if (!lock) return fail(lock.error());
  return link_to(id ? *id : std::string());
}

Result<> Generations::go_back(const std::string& id, Utc now, std::string why) const {
  // Noted first: if the power goes in between, the next start reads why and goes on from there.
  auto noted = change(id, [&](Generation& generation) { generation.went_back = WentBack{now, std::move(why)}; });
  if (!noted) return noted;
  const auto lock = locked(folder_);
  if (!lock) return fail(lock.error());
  if (current_id() != id) return {};
  const auto to = before(id);
  return link_to(to ? to->id : std::string());
}

Result<> Generations::note_start(const std::string& id) const {
  return change(id, [](Generation& generation) { ++generation.starts; });
}

Result<> Generations::note_proven(const std::string& id, Utc now) const {
  return change(id, [&](Generation& generation) {
    generation.proven = now;
    generation.starts = 0;
  });
}

Result<> Generations::note_failed_before(const std::string& id, std::vector<std::string> checks) const {
  return change(id, [&](Generation& generation) { generation.failed_before = std::move(checks); });
}

// Hidden first, so that what a power cut leaves of it is no generation.
Result<> Generations::remove(const std::string& id) const {
  const auto lock = locked(folder_);
  if (!lock) return fail(lock.error());
  const auto hidden = fs::path(hidden_folder(folder_).string() + "-" + id);
  if (::rename((folder_ / id).c_str(), hidden.c_str()) != 0)
    return fail(FaultKind::io, "{}: cannot be removed: {}", (folder_ / id).string(), std::strerror(errno));
  std::error_code error;
  fs::remove(folder_ / (id + ".json"), error);
  if (auto written = write_through_names(folder_); !written) return written;
  fs::remove_all(hidden, error);
  return {};
}

void Generations::prune() const {
  const auto shown = current_id();
  const auto back = before(shown);
  std::size_t kept = 0;
  for (const auto& generation : all())
    if (generation.id == shown || (back && generation.id == back->id)) ++kept;
  for (const auto& generation : all()) {
    if (generation.id == shown || (back && generation.id == back->id) || kept++ < kKept) continue;
    (void)remove(generation.id);  // the next installation tries again
  }
}

fs::path ContentPlace::configuration() const {
  const auto current = generations.current();
  return current ? generations.config_of(*current) : config;
}

}  // namespace kasumi
