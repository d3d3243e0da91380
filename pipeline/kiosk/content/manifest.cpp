#include "pipeline/kiosk/content/manifest.hpp"

#include <algorithm>
#include <numeric>
#include <set>

#include <nlohmann/json.hpp>

#include "base/outside/json_depth.hpp"
#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"
#include "pipeline/kiosk/content/digest.hpp"

namespace kasumi {

namespace {

using ManifestJson = nlohmann::ordered_json;

constexpr std::size_t kMostTitleBytes = 100;

std::string json_text_of(const ManifestJson& json, const char* key) {
  return json.is_object() && json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : std::string();
}

bool is_sha256(std::string_view text) {
  return text.size() == 64 &&
         std::ranges::all_of(text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

PackedFile read_packed_file(const ManifestJson& json, Problems& problems) {
  PackedFile file{json_text_of(json, "path"), 0, json_text_of(json, "sha256")};
  if (const auto problem = name_problem(file.path); !problem.empty())
    problems.add("{}: {}", kManifestName, problem);
  else if (!json.contains("bytes") || !json["bytes"].is_number_unsigned())
    problems.add("{}: {}: expected its \"bytes\"", kManifestName, file.path);
  else if (file.bytes = json["bytes"].get<std::uint64_t>(); file.bytes > kMostFileBytes)
    problems.add("{}: {}: {} bytes, expected at most {}", kManifestName, file.path, file.bytes, kMostFileBytes);
  else if (!is_sha256(file.sha256))
    problems.add("{}: {}: expected its \"sha256\", 64 digits", kManifestName, file.path);
  return file;
}

void read_kiosks(const ManifestJson& json, Manifest& manifest, Problems& problems) {
  if (!json.contains("for")) return;
  const auto& named = json["for"];
  if (named.is_array() && !named.empty() && named.size() <= kMostKiosks)
    for (const auto& name : named)
      if (name.is_string() && !name.get<std::string>().empty()) manifest.for_kiosks.push_back(name.get<std::string>());
  if (manifest.for_kiosks.empty() || manifest.for_kiosks.size() != named.size())
    problems.add("{}: for: expected 1 to {} names of kiosks", kManifestName, kMostKiosks);
}

// No file twice, and none where another one's folder is.
void check_names(const Manifest& manifest, Problems& problems) {
  std::set<std::string> names, folders;
  for (const auto& file : manifest.files) {
    if (!names.insert(file.path).second) problems.add("{}: {}: named twice", kManifestName, file.path);
    for (auto at = file.path.find('/'); at != std::string::npos; at = file.path.find('/', at + 1))
      folders.insert(file.path.substr(0, at));
  }
  for (const auto& name : names)
    if (folders.contains(name)) problems.add("{}: {}: a file, and a folder of another", kManifestName, name);
  for (const char* own : {kManifestName, kSignatureName})
    if (names.contains(own) || folders.contains(own))
      problems.add("{}: names {} among its files, which is the bundle's own", kManifestName, own);
  if (!names.contains(manifest.configuration) || manifest.configuration.find('/') != std::string::npos)
    problems.add("{}: configuration = \"{}\": expected one of its files, in no folder", kManifestName,
                 manifest.configuration);
}

}  // namespace

std::uint64_t Manifest::bytes() const {
  return std::accumulate(files.begin(), files.end(), std::uint64_t{0},
                         [](std::uint64_t sum, const PackedFile& file) { return sum + file.bytes; });
}

std::string name_problem(std::string_view path) {
  const auto shown = [&] {
    std::string text(path.substr(0, 80));
    for (char& c : text)
      if (static_cast<unsigned char>(c) < ' ' || c == 127) c = '?';
    return "\"" + text + "\"";
  };
  if (path.empty()) return "a file without a name";
  if (path.size() > kMostNameBytes) return fmt::format("{}: a name of more than {} bytes", shown(), kMostNameBytes);
  if (path.front() == '/') return shown() + ": an absolute name, expected one below the bundle's folder";
  if (std::ranges::any_of(path, [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 127 || c == '\\'; }))
    return shown() + ": control characters or a backslash in its name";
  std::size_t parts = 0;
  for (auto rest = path; ++parts;) {
    const auto slash = rest.find('/');
    const auto part = rest.substr(0, slash);
    if (part == ".." || part == ".") return shown() + ": leads out of its folder";
    if (part.empty()) return shown() + ": a folder without a name";
    if (part.front() == '.') return shown() + ": a hidden file or folder";
    if (slash == std::string_view::npos) break;
    rest.remove_prefix(slash + 1);
  }
  if (parts > kMostFolders + 1) return fmt::format("{}: more than {} folders deep", shown(), kMostFolders);
  return {};
}

std::string manifest_text(const Manifest& manifest) {
  ManifestJson files = ManifestJson::array();
  for (const auto& file : manifest.files)
    files.push_back({{"path", file.path}, {"bytes", file.bytes}, {"sha256", file.sha256}});
  ManifestJson json{{"format", "kasumi-content"},
                    {"version", 1},
                    {"name", manifest.name},
                    {"created_utc", utc_text(manifest.created)},
                    {"configuration", manifest.configuration},
                    {"files", files}};
  if (!manifest.for_kiosks.empty()) json["for"] = manifest.for_kiosks;
  return text_of_json(json, 1) + "\n";
}

Result<Manifest> parse_manifest(std::string_view text) try {
  const auto json = parse_ordered_json(modest_json(text));
  if (!json.is_object() || json_text_of(json, "format") != "kasumi-content")
    return fail(FaultKind::bad_input, "{}: not the manifest of a bundle for Kasumi", kManifestName);
  if (!json.contains("version") || json["version"] != 1)
    return fail(FaultKind::bad_input, "{}: of a version that this program does not know, expected 1", kManifestName);
  Problems problems;
  Manifest manifest{json_text_of(json, "name"), {}, json_text_of(json, "configuration"), {}};
  if (manifest.name.empty() || manifest.name.size() > kMostTitleBytes ||
      std::ranges::any_of(manifest.name, [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 127; }))
    problems.add("{}: name: expected 1 to {} bytes in one line", kManifestName, kMostTitleBytes);
  if (const auto created = parse_utc(json_text_of(json, "created_utc")))
    manifest.created = *created;
  else
    problems.add("{}: created_utc: expected a time like 2026-06-21T03:00:00Z", kManifestName);
  read_kiosks(json, manifest, problems);
  if (!json.contains("files") || !json["files"].is_array() || json["files"].empty() ||
      json["files"].size() > kMostFiles) {
    problems.add("{}: files: expected a list of 1 to {}", kManifestName, kMostFiles);
    return fail(problems.fault());
  }
  for (const auto& file : json["files"]) manifest.files.push_back(read_packed_file(file, problems));
  check_names(manifest, problems);
  if (manifest.bytes() > kMostBytes)
    problems.add("{}: {} bytes in all, expected at most {}", kManifestName, manifest.bytes(), kMostBytes);
  if (!problems.empty()) return fail(problems.fault());
  return manifest;
} catch (const std::exception& thrown) {
  return fail(FaultKind::bad_input, "{}: cannot be read: {}", kManifestName, thrown.what());
}

std::string content_id(std::string_view manifest_text) {
  return sha256_of(manifest_text).substr(0, 16);
}

}  // namespace kasumi
