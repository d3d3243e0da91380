#include "gles/model/model_file.hpp"

#include <algorithm>

#include "base/files.hpp"
#include "gles/model/model_json.hpp"

namespace kasumi {
namespace {

namespace fs = std::filesystem;

// The files tinygltf may read: regular files within the model's folder tree, up to the size limit.
struct Folder {
  fs::path root;  // canonical
  std::size_t largest_file;
  fs::path given;                          // as it was named
  std::vector<fs::path>* files;            // that were read
  std::vector<std::string>* notes;         // on the model
  FaultKind fault = FaultKind::bad_input;  // io: a file could not be read
  std::string missing{};                   // the first file that is not there, and what was expected

  bool holds(const std::string& name) const {
    std::error_code error;
    const fs::path whole = fs::canonical(name, error);
    if (error || !fs::is_regular_file(whole, error)) return false;
    return std::ranges::mismatch(root, whole).in1 == root.end();
  }
};

std::string without_case(std::string name) {
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name;
}

// The name as the folder below has it, where Windows would find it, too: any case, backslashes. Empty: it is not there.
fs::path other_spelling(const fs::path& root, std::string name) {
  std::ranges::replace(name, '\\', '/');
  fs::path at = root;
  for (const fs::path& part : fs::path(name).lexically_normal().lexically_relative(root)) {
    if (part == "..") return {};
    std::error_code error;
    if (fs::exists(at / part, error)) {
      at /= part;
      continue;
    }
    const std::string wanted = without_case(part.string());
    auto entry = fs::directory_iterator(at, error);
    while (!error && entry != fs::end(entry) && without_case(entry->path().filename().string()) != wanted)
      entry.increment(error);
    if (error || entry == fs::end(entry)) return {};
    at = entry->path();
  }
  return at;
}

// The only file in the folder's tree that bears the last part of a name, in any case: many a model names its pictures
// as they lay on the machine that made it. Empty: none, several, or a tree too large to be searched.
fs::path elsewhere_in(const Folder& folder, const std::string& name) {
  constexpr int kMostEntries = 4096;
  const std::string wanted = without_case(name.substr(name.find_last_of("/\\") + 1));
  fs::path found;
  int entries = 0;
  std::error_code error;
  for (auto it = fs::recursive_directory_iterator(folder.root, error); !error && it != fs::end(it);
       it.increment(error)) {
    if (++entries > kMostEntries) return {};
    if (without_case(it->path().filename().string()) != wanted || !folder.holds(it->path().string())) continue;
    if (!found.empty()) return {};
    found = it->path();
  }
  return error ? fs::path() : found;
}

std::string found_name(const std::string& name, void* folder) {
  const auto& allowed = *static_cast<const Folder*>(folder);
  if (allowed.holds(name)) return name;
  fs::path other = other_spelling(allowed.root, name);
  if (other.empty()) other = elsewhere_in(allowed, name);
  if (other.empty() || !allowed.holds(other.string())) return name;
  allowed.notes->push_back(fmt::format("{}: read instead of {}, which is not there", other.string(),
                                       name.substr(allowed.root.string().size() + 1)));
  return other.string();
}

bool file_exists(const std::string& name, void* folder) {
  auto& allowed = *static_cast<Folder*>(folder);
  if (allowed.holds(name)) return true;
  const std::string below = allowed.root.string() + "/";
  if (!allowed.missing.empty() || !name.starts_with(below)) return false;
  std::error_code error;
  const std::string uri = name.substr(below.size());
  const char* why = uri.find("://") != std::string::npos ? "lies elsewhere: expected a file in the model's folder"
                    : fs::exists(name, error)            ? "lies outside of the model's folder: expected it there"
                                                         : "is missing: expected it in the model's folder";
  allowed.missing = fmt::format("{}, which it needs, {}", uri, why);
  return false;
}

bool read_whole_file(std::vector<unsigned char>* bytes, std::string* error, const std::string& name, void* folder) {
  auto& allowed = *static_cast<Folder*>(folder);
  std::error_code size_error;
  if (!allowed.holds(name)) {
    *error = "not in the model's folder";
  } else if (fs::file_size(name, size_error) > allowed.largest_file || size_error) {
    *error = fmt::format("larger than {} bytes", allowed.largest_file);
  } else if (auto read = read_file(name)) {
    *bytes = std::move(*read);
    allowed.files->push_back(allowed.given / fs::path(name).lexically_relative(allowed.root));
    return true;
  } else {
    *error = read.error().message;
    if (read.error().kind == FaultKind::io) allowed.fault = FaultKind::io;
  }
  return false;
}

bool refuse_writing(std::string* error, const std::string&, const std::vector<unsigned char>&, void*) {
  *error = "models are read-only";
  return false;
}

// Pictures are decoded later, once it is known which are needed.
bool keep_picture(tinygltf::Image* image, int, std::string*, std::string*, int, int, const unsigned char* bytes,
                  int size, void*) {
  image->as_is = true;
  if (size > 0) image->image.assign(bytes, bytes + size);
  return true;
}

// The file with another JSON in its place.
std::vector<std::uint8_t> with_json(const std::vector<std::uint8_t>& file, std::string_view before, std::string json,
                                    bool binary) {
  if (!binary) return {json.begin(), json.end()};
  while (json.size() % 4 != 0) json += ' ';
  const std::size_t rest = 20 + before.size();
  std::vector<std::uint8_t> made(file.begin(), file.begin() + 20);
  made.insert(made.end(), json.begin(), json.end());
  made.insert(made.end(), file.begin() + static_cast<std::ptrdiff_t>(rest), file.end());
  const auto put = [&](std::size_t at, std::size_t value) {
    for (std::size_t i = 0; i < 4; ++i) made[at + i] = static_cast<std::uint8_t>(value >> 8 * i);
  };
  put(8, made.size());
  put(12, json.size());
  return made;
}

// tinygltf's messages have several lines.
std::string one_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  std::string line;
  for (const char c : text) line += c == '\n' ? std::string("; ") : std::string(1, c);
  return line;
}

}  // namespace

Result<tinygltf::Model> parse_gltf(const fs::path& path, const ModelLimits& limits, std::vector<std::string>& notes,
                                   std::vector<std::filesystem::path>& files, std::vector<std::string>& extensions) {
  const std::string name = path.string();
  std::error_code size_error;
  const std::uintmax_t size = fs::file_size(path, size_error);
  if (!size_error && size > limits.file_bytes)
    return fail(FaultKind::bad_input, "{}: {} bytes: expected {} at most", name, size, limits.file_bytes);
  const auto file = read_file(path);
  if (!file) return fail(file.error());
  files.push_back(path);
  const auto json = gltf_json(*file, name);
  if (!json) return fail(json.error());
  auto claims = check_gltf_json(*json, name);
  if (!claims) return fail(claims.error());
  notes.insert(notes.end(), claims->notes.begin(), claims->notes.end());
  extensions = std::move(claims->extensions);
  const bool binary = json->data() != reinterpret_cast<const char*>(file->data());
  std::span<const std::uint8_t> bytes = *file;
  std::vector<std::uint8_t> mended;
  if (claims->to_mend) {
    mended = with_json(*file, *json, mended_json(*json), binary);
    bytes = mended;
  }

  std::error_code folder_error;
  const fs::path parent = path.has_parent_path() ? path.parent_path() : fs::path(".");
  Folder folder{fs::canonical(parent, folder_error), limits.file_bytes, parent, &files, &notes};
  if (folder_error) return fail(FaultKind::io, "{}: {}", parent.string(), folder_error.message());

  tinygltf::Model gltf;
  std::string error, warning;
  bool parsed = false;
  try {
    tinygltf::TinyGLTF parser;
    parser.SetFsCallbacks({file_exists, found_name, read_whole_file, refuse_writing, &folder});
    parser.SetImageLoader(keep_picture, nullptr);
    const auto length = static_cast<unsigned>(bytes.size());
    const auto* text = reinterpret_cast<const char*>(bytes.data());
    parsed = binary ? parser.LoadBinaryFromMemory(&gltf, &error, &warning, bytes.data(), length, folder.root.string())
                    : parser.LoadASCIIFromString(&gltf, &error, &warning, text, length, folder.root.string());
  } catch (const std::exception& thrown) {
    error += thrown.what();
  }
  if (!parsed && error.find("File not found") != std::string::npos && !folder.missing.empty())
    return fail(FaultKind::bad_input, "{}: {}", name, folder.missing);
  if (!parsed) return fail(folder.fault, "{}: {}", name, one_line(error.empty() ? warning : error));
  if (!warning.empty()) notes.push_back(fmt::format("{}: {}", name, one_line(warning)));
  return gltf;
}

}  // namespace kasumi
