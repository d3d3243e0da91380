#include "gles/model/model_file.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <map>
#include <optional>
#include <span>

#include "base/files.hpp"
#include "gles/model/gltf_values.hpp"
#include "gles/model/model_json.hpp"
#include "gles/model/other_models.hpp"

namespace kasumi {
namespace {

namespace fs = std::filesystem;

// The files tinygltf may read: regular files within the model's folder tree, up to the size limit.
struct Folder {
  fs::path root;  // canonical
  const ModelLimits& limits;
  fs::path given;                                          // as it was named
  std::vector<fs::path>* files;                            // that were read
  std::vector<std::string>* notes;                         // on the model
  FaultKind fault = FaultKind::bad_input;                  // io: a file could not be read
  std::string missing{};                                   // the first file that is not there, and what was expected
  std::size_t bytes = 0;                                   // of files and pictures so far
  std::string refused{};                                   // why nothing of it is shown
  std::optional<std::map<std::string, fs::path>> names{};  // listed() in this folder

  bool has_room_for(std::size_t more) {
    if (more > limits.all_bytes - bytes)
      refused = fmt::format("its files and pictures, each as often as it is named, have more than {} bytes",
                            limits.all_bytes);
    else
      bytes += more;
    return refused.empty();
  }

  bool holds(const std::string& name) const {
    std::error_code error;
    const fs::path whole = fs::canonical(name, error);
    if (error || !fs::is_regular_file(whole, error)) return false;
    return std::ranges::mismatch(root, whole).in1 == root.end();
  }
};

// Names that mean the same: in any case, encoded as in addresses or not ("a%20b.png"; tinygltf reads + as a space).
std::string alike(const std::string& name) {
  std::string plain;
  for (std::size_t i = 0; i < name.size(); ++i) {
    unsigned byte = static_cast<unsigned char>(name[i] == '+' ? ' ' : name[i]);
    if (name[i] == '%' && i + 2 < name.size() &&
        std::from_chars(name.data() + i + 1, name.data() + i + 3, byte, 16).ptr == name.data() + i + 3)
      i += 2;
    plain += static_cast<char>(std::tolower(static_cast<int>(byte)));
  }
  return plain;
}

// The files of the folder's tree: each by its path in it, and by its name alone where no other bears that, both alike()
// (many a model names its pictures as they lay on the machine that made it). Empty: none, or a tree too large to list.
const std::map<std::string, fs::path>& listed(Folder& folder) {
  constexpr int kMostEntries = 100'000;
  if (folder.names) return *folder.names;
  auto& names = folder.names.emplace();
  std::map<std::string, fs::path> alone;
  int entries = 0;
  std::error_code error;
  for (auto it = fs::recursive_directory_iterator(folder.root, error); !error && it != fs::end(it);
       it.increment(error)) {
    if (++entries > kMostEntries) return names = {};
    std::error_code unknown;
    if (!it->is_regular_file(unknown)) continue;
    names[alike(it->path().lexically_relative(folder.root).string())] = it->path();
    const auto [other, first] = alone.try_emplace("*" + alike(it->path().filename().string()), it->path());
    if (!first) other->second.clear();
  }
  names.merge(alone);
  return names;
}

// Where Windows would find it, too (any case, backslashes); else the only file of that name. Empty: it is not there.
fs::path elsewhere_in(Folder& folder, std::string name) {
  std::ranges::replace(name, '\\', '/');
  const fs::path whole = fs::path(name).lexically_normal();
  if (folder.holds(whole.string())) return whole;
  const auto& names = listed(folder);
  for (const auto& wanted : {whole.lexically_relative(folder.root).string(), "*" + whole.filename().string()})
    if (const auto at = names.find(alike(wanted)); at != names.end() && folder.holds(at->second.string()))
      return at->second;
  return {};
}

std::string found_name(const std::string& name, void* folder) {
  auto& allowed = *static_cast<Folder*>(folder);
  if (allowed.holds(name)) return name;
  const fs::path other = elsewhere_in(allowed, name);
  if (other.empty()) return name;
  add_note(*allowed.notes, fmt::format("{}: read instead of {}, which is not there", other.string(),
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
  } else if (fs::file_size(name, size_error) > allowed.limits.file_bytes || size_error) {
    *error = fmt::format("larger than {} bytes", allowed.limits.file_bytes);
  } else if (!allowed.has_room_for(fs::file_size(name, size_error))) {
    *error = "too much";
  } else if (auto read = read_file(name)) {
    if (const auto other = other_than_data(*read); !other.empty()) {
      allowed.refused = fmt::format("{}, which it needs, is {}", name.substr(allowed.root.string().size() + 1), other);
      return false;
    }
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
                  int size, void* folder) {
  image->as_is = true;
  if (size > 0 && !static_cast<Folder*>(folder)->has_room_for(static_cast<std::size_t>(size))) return false;
  if (size > 0) image->image.assign(bytes, bytes + size);
  return true;
}

std::size_t word_at(std::span<const std::uint8_t> file, std::size_t at) {
  std::size_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | file[at + i];
  return value;
}

// A GLB's binary chunk as far as the file goes; empty: none.
std::span<const std::uint8_t> binary_chunk(std::span<const std::uint8_t> file, std::string_view json) {
  const std::size_t at = 20 + json.size();
  if (at + 8 > file.size() || std::memcmp(file.data() + at + 4, "BIN\0", 4) != 0) return {};
  return file.subspan(at + 8, std::min(word_at(file, at), file.size() - at - 8));
}

// Whether a GLB's lengths are what tinygltf asks for: some exporters do not pad the chunks, or count wrongly.
bool is_regular(std::span<const std::uint8_t> file, std::string_view json) {
  const auto chunk = binary_chunk(file, json);
  const std::size_t end = 20 + json.size() + (chunk.empty() ? 0 : 8 + chunk.size());
  return json.size() % 4 == 0 && chunk.size() % 4 == 0 && word_at(file, 8) >= end &&
         (chunk.empty() || chunk.size() == word_at(file, 20 + json.size()));
}

// The file with another JSON in its place, and its chunks as they should be.
std::vector<std::uint8_t> with_json(std::span<const std::uint8_t> file, std::string_view before, std::string json,
                                    bool binary) {
  if (!binary) return {json.begin(), json.end()};
  const auto chunk = binary_chunk(file, before);
  std::vector<std::uint8_t> made(file.begin(), file.begin() + 20);
  const auto put = [&](std::size_t at, std::size_t value) {
    for (std::size_t i = 0; i < 4; ++i) made[at + i] = static_cast<std::uint8_t>(value >> 8 * i);
  };
  made.insert(made.end(), json.begin(), json.end());
  made.resize((made.size() + 3) / 4 * 4, ' ');
  put(12, made.size() - 20);
  if (!chunk.empty()) {
    const std::size_t at = made.size();
    made.insert(made.end(), {0, 0, 0, 0, 'B', 'I', 'N', 0});
    made.insert(made.end(), chunk.begin(), chunk.end());
    made.resize((made.size() + 3) / 4 * 4);
    put(at, made.size() - at - 8);
  }
  put(8, made.size());
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
  auto claims = check_gltf_json(*json, name, limits.json_values);
  if (!claims) return fail(claims.error());
  notes.insert(notes.end(), claims->notes.begin(), claims->notes.end());
  extensions = std::move(claims->extensions);
  const bool binary = json->data() != reinterpret_cast<const char*>(file->data());
  std::span<const std::uint8_t> bytes = *file;
  std::vector<std::uint8_t> mended;
  if (claims->to_mend || (binary && !is_regular(bytes, *json))) {
    mended = with_json(bytes, *json, claims->to_mend ? mended_json(*json) : std::string(*json), binary);
    bytes = mended;
  }

  std::error_code folder_error;
  const fs::path parent = path.has_parent_path() ? path.parent_path() : fs::path(".");
  Folder folder{fs::canonical(parent, folder_error), limits, parent, &files, &notes};
  if (folder_error) return fail(FaultKind::io, "{}: {}", parent.string(), folder_error.message());

  tinygltf::Model gltf;
  std::string error, warning;
  bool parsed = false;
  try {
    tinygltf::TinyGLTF parser;
    parser.SetFsCallbacks({file_exists, found_name, read_whole_file, refuse_writing, &folder});
    parser.SetImageLoader(keep_picture, &folder);
    const auto length = static_cast<unsigned>(bytes.size());
    const auto* text = reinterpret_cast<const char*>(bytes.data());
    parsed = binary ? parser.LoadBinaryFromMemory(&gltf, &error, &warning, bytes.data(), length, folder.root.string())
                    : parser.LoadASCIIFromString(&gltf, &error, &warning, text, length, folder.root.string());
  } catch (const std::exception& thrown) {
    error += thrown.what();
  }
  if (!folder.refused.empty()) return fail(FaultKind::bad_input, "{}: {}", name, folder.refused);
  if (!parsed && error.find("File not found") != std::string::npos && !folder.missing.empty())
    return fail(FaultKind::bad_input, "{}: {}", name, folder.missing);
  if (!parsed) return fail(folder.fault, "{}: {}", name, one_line(error.empty() ? warning : error));
  if (!warning.empty()) add_note(notes, fmt::format("{}: {}", name, one_line(warning)));
  return gltf;
}

}  // namespace kasumi
