#include "pipeline/start/kept_content.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/table/config_table.hpp"
#include "base/utc_text.hpp"

namespace kasumi {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// What is kept: its files as they were in their own places, and which of the two folders holds the copies. The other
// is filled next, so that there is always a whole one.
struct Kept {
  std::string folder;
  Utc utc{};
  std::vector<ContentFile> files;
};

fs::path kept_file(const fs::path& folder) {
  return folder / "kept.json";
}

Result<Kept> read_kept(const fs::path& folder) try {
  const auto text = read_text_file(kept_file(folder));
  if (!text) return fail(text.error());
  const auto json = Json::parse(*text, nullptr, false);
  const auto string = [](const Json& in, const char* key) {
    return in.is_object() && in.contains(key) && in[key].is_string() ? in[key].get<std::string>() : std::string();
  };
  const auto utc = parse_utc(string(json, "utc"));
  Kept kept{string(json, "folder"), utc.value_or(Utc{}), {}};
  if (!utc || (kept.folder != "a" && kept.folder != "b") || !json.contains("files"))
    return fail(FaultKind::bad_input, "{}: damaged: expected \"folder\", \"utc\" and \"files\"",
                kept_file(folder).string());
  for (const auto& file : json["files"])
    if (file.is_object())
      kept.files.push_back(
          {string(file, "path"), file.value("bytes", std::uintmax_t{0}), file.value("changed_ns", std::int64_t{0})});
  return kept;
} catch (const Json::exception& thrown) {
  return fail(FaultKind::bad_input, "{}: damaged: {}", kept_file(folder).string(), thrown.what());
}

std::string json_text(const Kept& kept) {
  Json files = Json::array();
  for (const auto& file : kept.files)
    files.push_back({{"path", file.path.string()}, {"bytes", file.bytes}, {"changed_ns", file.changed_ns}});
  return Json{{"folder", kept.folder}, {"utc", utc_text(kept.utc)}, {"files", files}}.dump(
             1, ' ', false, Json::error_handler_t::replace) +
         "\n";
}

Result<> copy(const ContentFile& file, const fs::path& copies) {
  const auto to = ConfigTable::place_of_copy(file.path, copies);
  std::error_code error;
  fs::create_directories(to.parent_path(), error);
  if (error) return fail(FaultKind::io, "{}: cannot be made: {}", to.parent_path().string(), error.message());
  const auto bytes = read_file(file.path);
  if (!bytes) return fail(bytes.error());
  return write_file(to, *bytes);
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
  const auto kept = read_kept(folder);
  return kept && kept->files == content.files;
}

Result<> keep_content(const Content& content, const fs::path& folder, Utc now) {
  if (auto same = unchanged(content.files); !same) return same;
  const auto before = read_kept(folder);
  if (before && before->files == content.files) return {};
  const Kept next{before && before->folder == "a" ? "b" : "a", now, content.files};
  const auto copies = folder / next.folder;
  std::error_code error;
  fs::remove_all(copies, error);
  for (const auto& file : next.files)
    if (auto copied = copy(file, copies); !copied) return copied;
  if (auto same = unchanged(content.files); !same) return same;
  if (auto readable = read_content(content.files.front().path, copies); !readable) return fail(readable.error());
  if (auto written = write_text_file(kept_file(folder), json_text(next)); !written) return written;
  if (before) fs::remove_all(folder / before->folder, error);  // the disk is small
  return {};
}

Result<ContentPtr> read_kept_content(const fs::path& config_file, const fs::path& folder,
                                     std::vector<std::string> refused) {
  const auto kept = read_kept(folder);
  if (!kept) return fail(kept.error());
  const auto content = read_content(config_file, folder / kept->folder);
  if (!content) return content;
  auto instead = std::make_shared<Content>(**content);
  instead->instead = InsteadOfConfigured{kept->utc, std::move(refused)};
  return ContentPtr(std::move(instead));
}

}  // namespace kasumi
