#include "pipeline/kiosk/start/kept_content.hpp"

#include <cstdint>
#include <span>
#include <utility>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_depth.hpp"
#include "base/outside/json_text.hpp"
#include "base/table/config_table.hpp"
#include "base/utc_text.hpp"
#include "pipeline/kiosk/start/file_hash.hpp"

namespace kasumi {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// What is kept: its files as they were in their own places, and which of the two folders holds the copies.
struct KeptFile {
  ContentFile file;
  std::string hash;  // of the copy, so that a damaged one is never taken for content; empty: kept by an older version
};
struct Kept {
  std::string folder;
  Utc utc{};
  std::vector<KeptFile> files;
  std::vector<ContentFile> originals() const {
    std::vector<ContentFile> plain;
    for (const auto& kept : files) plain.push_back(kept.file);
    return plain;
  }
};

// Two generations, each with a note of its own: what is damaged in one is whole in the other.
constexpr const char* kNewest = "kept.json";
constexpr const char* kBefore = "before.json";

Result<Kept> read_kept(const fs::path& note) try {
  const auto text = read_text_file(note, kSmallFile);
  if (!text) return fail(text.error());
  const auto json = parse_json(modest_json(*text));
  const auto string = [](const Json& in, const char* key) {
    return in.is_object() && in.contains(key) && in[key].is_string() ? in[key].get<std::string>() : std::string();
  };
  const auto utc = parse_utc(string(json, "utc"));
  Kept kept{string(json, "folder"), utc.value_or(Utc{}), {}};
  if (!utc || (kept.folder != "a" && kept.folder != "b") || !json.contains("files"))
    return fail(FaultKind::bad_input, "{}: damaged: expected \"folder\", \"utc\" and \"files\"", note.string());
  for (const auto& file : json["files"])
    if (file.is_object())
      kept.files.push_back(
          {{string(file, "path"), file.value("bytes", std::uintmax_t{0}), file.value("changed_ns", std::int64_t{0})},
           string(file, "hash")});
  return kept;
} catch (const Json::exception& thrown) {
  return fail(FaultKind::bad_input, "{}: damaged: {}", note.string(), thrown.what());
}

std::string json_text(const Kept& kept) {
  Json files = Json::array();
  for (const auto& [file, hash] : kept.files)
    files.push_back(
        {{"path", file.path.string()}, {"bytes", file.bytes}, {"changed_ns", file.changed_ns}, {"hash", hash}});
  return text_of_json(Json{{"folder", kept.folder}, {"utc", utc_text(kept.utc)}, {"files", files}}, 1) + "\n";
}

// FNV-1a, 64 bits: against what a disk does, not against people.
std::string hash_of_copy(std::span<const std::uint8_t> bytes) {
  FileHash hash;
  hash.add(bytes);
  return hash.hex();
}

// Returns its hash.
Result<std::string> copy(const ContentFile& file, const fs::path& copies) {
  const auto to = ConfigTable::place_of_copy(file.path, copies);
  std::error_code error;
  fs::create_directories(to.parent_path(), error);
  if (error) return fail(FaultKind::io, "{}: cannot be made: {}", to.parent_path().string(), error.message());
  const auto bytes = read_file(file.path);
  if (!bytes) return fail(bytes.error());
  if (auto written = write_file(to, *bytes); !written) return fail(written.error());
  return hash_of_copy(*bytes);
}

Result<> undamaged(const Kept& kept, const fs::path& copies) {
  for (const auto& [file, hash] : kept.files) {
    const auto place = ConfigTable::place_of_copy(file.path, copies);
    const auto bytes = read_file(place);
    if (!bytes) return fail(bytes.error());
    if (!hash.empty() && hash_of_copy(*bytes) != hash)
      return fail(FaultKind::bad_input, "{}: damaged since it was kept", place.string());
  }
  return {};
}

// What is shown is what was read, which a later edit is not.
Result<> unchanged(const std::vector<ContentFile>& files) {
  for (const auto& file : files)
    if (content_file(file.path) != file)
      return fail(FaultKind::bad_input, "{}: has changed since it was read", file.path.string());
  return {};
}

}  // namespace

bool is_kept(const Content& content, const fs::path& folder) {
  const auto kept = read_kept(folder / kNewest);
  return kept && kept->originals() == content.files;
}

// The note before the newest one names the folder that is filled next, so it goes first and comes last.
Result<> keep_content(const Content& content, const fs::path& folder, Utc now) {
  if (auto same = unchanged(content.files); !same) return same;
  const auto newest = read_kept(folder / kNewest);
  if (newest && newest->originals() == content.files && undamaged(*newest, folder / newest->folder)) return {};
  Kept next{newest && newest->folder == "a" ? "b" : "a", now, {}};
  const auto copies = folder / next.folder;
  std::error_code error;
  fs::remove(folder / kBefore, error);
  fs::remove_all(copies, error);
  for (const auto& file : content.files) {
    auto hash = copy(file, copies);
    if (!hash) return fail(hash.error());
    next.files.push_back({file, std::move(*hash)});
  }
  if (auto same = unchanged(content.files); !same) return same;
  if (auto readable = read_content(content.files.front().path, copies); !readable) return fail(readable.error());
  if (newest) fs::rename(folder / kNewest, folder / kBefore, error);
  return write_text_file(folder / kNewest, json_text(next));
}

Result<ContentPtr> read_kept_content(const fs::path& config_file, const fs::path& folder,
                                     std::vector<std::string> refused) {
  tl::unexpected<Fault> why = fail(FaultKind::bad_input, "{}: nothing was kept", folder.string());
  bool any = false;
  for (const char* note : {kNewest, kBefore}) {
    const auto kept = read_kept(folder / note);
    const auto whole = kept ? undamaged(*kept, folder / kept->folder) : Result<>(fail(kept.error()));
    const auto content = whole ? read_content(config_file, folder / kept->folder) : fail(whole.error());
    if (content) {
      auto instead = std::make_shared<Content>(**content);
      instead->instead = InsteadOfConfigured{kept->utc, std::move(refused)};
      return ContentPtr(std::move(instead));
    }
    if (!std::exchange(any, true)) why = fail(content.error());
  }
  return why;
}

}  // namespace kasumi
