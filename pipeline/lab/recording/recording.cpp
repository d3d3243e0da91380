#include "pipeline/lab/recording/recording.hpp"

#include <set>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/lasting_file.hpp"
#include "base/outside/json_depth.hpp"
#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"
#include "pipeline/machine/time_watch.hpp"
#include "pipeline/site/config/run_config.hpp"

namespace kasumi {

namespace {

std::size_t index_of(CameraRole role) {
  return role == CameraRole::sky ? 0 : 1;
}

Result<> keep_copy(const std::filesystem::path& from, const std::filesystem::path& to) {
  const auto bytes = read_file(from);
  if (!bytes) return fail(bytes.error());
  if (auto made = create_folders(to.parent_path()); !made) return made;
  return write_file(to, *bytes);
}

// The files in its folder that a .gltf refers to. Errors are ignored: the model's reader reports them.
std::set<std::filesystem::path> companions_of(const std::filesystem::path& model) {
  std::set<std::filesystem::path> found;
  if (model.extension() != ".gltf") return found;
  const auto text = read_text_file(model);
  const auto json = parse_json(modest_json(text.value_or(""), 256 << 20, 100));
  if (!json.is_object()) return found;
  for (const char* list : {"buffers", "images"}) {
    if (!json.contains(list) || !json[list].is_array()) continue;
    for (const auto& entry : json[list]) {
      if (!entry.is_object() || !entry.contains("uri") || !entry["uri"].is_string()) continue;
      const std::filesystem::path name = entry["uri"].get<std::string>();
      const auto plain = name.lexically_normal();
      const bool below = !plain.empty() && plain.is_relative() && *plain.begin() != "..";
      std::error_code error;
      if (below && std::filesystem::is_regular_file(model.parent_path() / plain, error)) found.insert(plain);
    }
  }
  return found;
}

// Copies the installation's files next to fixture.toml under unique names; returns the new values of their keys.
Result<std::map<std::string, std::optional<std::string>>> copy_files(const ConfigTable& root,
                                                                     const std::filesystem::path& folder) {
  std::map<std::string, std::optional<std::string>> changes;
  std::map<std::string, std::filesystem::path> taken;  // name of the copy, original file
  for (const auto& [key, file] : root.files_asked()) {
    const auto table = key.substr(0, key.find('.'));
    if (table != "sky" && table != "scene" && table != "object") continue;
    auto name = file.filename().string();
    if (const auto other = taken.find(name); other != taken.end() && other->second != file) name = table + "-" + name;
    taken[name] = file;
    changes[key] = name;
    if (auto copied = keep_copy(file, folder / name); !copied) return fail(copied.error());
    for (const auto& companion : companions_of(file))
      if (auto copied = keep_copy(file.parent_path() / companion, folder / companion); !copied)
        return fail(copied.error());
  }
  return changes;
}

// A folder's name may contain any bytes, TOML only UTF-8 and no quotes.
std::string plain(const std::string& name) {
  std::string text;
  for (const char c : name)
    if (c >= ' ' && c <= '~' && c != '"' && c != '\\') text += c;
  return text;
}

std::string head_of(const std::filesystem::path& folder, Utc start, const std::string& sources, bool synchronized) {
  const auto name = folder.has_filename() ? folder.filename() : folder.parent_path().filename();
  auto quoted = plain(name.string());
  if (quoted.empty()) quoted = "recording";
  return fmt::format(
      "format = {}\nname = \"{}\"\nlicence = \"LicenseRef-not-stated\"\nprovenance = \"Recorded by kasumi record from "
      "{}{}\"\nstart_utc = {}\n\n",
      kFixtureFormat, quoted, sources,
      synchronized ? "" : "; the machine's clock was not synchronized: utc may be wrong", utc_text(start));
}

}  // namespace

std::string sources_text(const RunConfig& config) {
  const auto* sky = std::get_if<ReplayCamera>(&config.sky_camera);
  const auto* scene = std::get_if<ReplayCamera>(&config.scene_camera);
  if (!sky && !scene) return "live cameras";
  const auto recording = [](const ReplayCamera& replay) {
    return fmt::format("a recording ({})", plain(replay.fixture.lexically_normal().string()));
  };
  if (sky && scene && sky->fixture == scene->fixture) return recording(*sky);
  return fmt::format("{} (sky) and {} (scene)", sky ? recording(*sky) : "a live camera",
                     scene ? recording(*scene) : "a live camera");
}

Result<std::unique_ptr<Recording>> Recording::create(const std::filesystem::path& config_file,
                                                     const std::filesystem::path& folder, Utc start,
                                                     const RecordingLimits& limits) {
  const auto root = ConfigTable::read_file(config_file);
  if (!root) return fail(root.error());
  const auto config = read_run_config(*root);
  if (auto whole = root->finish(); !whole) return fail(whole.error());

  std::error_code error;
  if (std::filesystem::exists(folder / "fixture.toml", error))
    return fail(FaultKind::bad_input, "{}: already contains a recording; expected a new folder", folder.string());
  if (auto made = create_folders(folder); !made) return fail(made.error());
  // Visitors may be seen in it: for its own account alone.
  std::filesystem::permissions(folder, std::filesystem::perms::owner_all, error);
  if (error) return fail(FaultKind::io, "{}: cannot be closed to others: {}", folder.string(), error.message());

  auto changes = copy_files(*root, folder);
  if (!changes) return fail(changes.error());
  (*changes)["sky.camera"] = std::nullopt;
  (*changes)["scene.camera"] = std::nullopt;
  const bool synchronized = watch_time()->read().synchronized;
  const auto text = head_of(folder, start, sources_text(config), synchronized) +
                    root->copy_of({"site", "sky", "scene", "object", "landmarks"}, *changes);
  if (auto written = write_text_file(folder / "fixture.toml", text); !written) return fail(written.error());

  // A live camera's frames all differ, and searching for equal ones would keep each in memory.
  const PayloadRules options{.share_equal_payloads = false};
  auto sky = FixtureWriter::create(folder / "sky", options);
  if (!sky) return fail(sky.error());
  auto scene = FixtureWriter::create(folder / "scene", options);
  if (!scene) return fail(scene.error());
  return std::unique_ptr<Recording>(new Recording(folder, limits, std::move(*sky), std::move(*scene)));
}

Result<> Recording::check_limits(std::uint64_t more) const {
  if (bytes() + more > limits_.most_bytes)
    return fail(FaultKind::end_of_stream, "{:.0f} MB recorded, the limit", static_cast<double>(bytes()) / 1e6);
  std::error_code error;
  const auto space = std::filesystem::space(folder_, error);
  if (error) return fail(FaultKind::io, "{}: {}", folder_.string(), error.message());
  if (space.available < limits_.keep_free + more)
    return fail(FaultKind::io, "{}: only {:.0f} MB left on the disk, and {:.0f} MB must stay free", folder_.string(),
                static_cast<double>(space.available) / 1e6, static_cast<double>(limits_.keep_free) / 1e6);
  return {};
}

Result<> Recording::keep(CameraRole role, const Frame& frame) {
  const std::lock_guard lock(mutexes_[index_of(role)]);
  if (auto room = check_limits(frame.payload.bytes.size()); !room) return room;
  auto& to = writer(role);
  auto kept = to.append(frame);
  bytes_[index_of(role)] = to.bytes_written();
  rows_[index_of(role)] = to.row_count();
  return kept;
}

Result<> Recording::keep_disconnect(CameraRole role, Instant at, Utc utc) {
  const std::lock_guard lock(mutexes_[index_of(role)]);
  auto& to = writer(role);
  auto kept = to.append_disconnect(at, utc);
  rows_[index_of(role)] = to.row_count();
  return kept;
}

int Recording::rows(CameraRole role) const {
  return rows_[index_of(role)];
}

std::uint64_t Recording::bytes() const {
  return bytes_[0] + bytes_[1];
}

}  // namespace kasumi
