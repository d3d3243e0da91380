#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>
#include <set>

#include <archive.h>
#include <archive_entry.h>
#include <fcntl.h>
#include <sys/stat.h>

#include "base/c_ptr.hpp"
#include "base/files.hpp"
#include "base/lasting_file.hpp"
#include "base/unfinished_file.hpp"
#include "pipeline/kiosk/content/bundle.hpp"
#include "pipeline/kiosk/content/digest.hpp"

namespace kasumi {

namespace {

namespace fs = std::filesystem;
using Archive = CPtr<archive, archive_read_free>;

constexpr std::size_t kPiece = 1 << 16;
constexpr std::size_t kMostProblems = 20;  // more do not help

// Plain tar and nothing else: no compression, whose bombs need bounds of their own.
Result<Archive> open_archive(const Bundle& bundle) {
  Archive reader(archive_read_new());
  if (!reader) return fail(FaultKind::io, "not enough memory");
  archive_read_support_format_tar(reader.get());
  if (::lseek(bundle.file.value(), 0, SEEK_SET) != 0)
    return fail(FaultKind::bad_input, "{}: expected a file", bundle.path.string());
  if (archive_read_open_fd(reader.get(), bundle.file.value(), kPiece) != ARCHIVE_OK)
    return fail(FaultKind::bad_input, "{}: not a bundle: {}", bundle.path.string(), archive_error_string(reader.get()));
  return reader;
}

std::string words_of(archive* reader) {
  const char* words = archive_error_string(reader);
  return words ? words : "damaged";
}

// The next entry; null at the end. What libarchive only warns of, it has read.
Result<archive_entry*> next_entry(archive* reader) {
  archive_entry* entry = nullptr;
  const int told = archive_read_next_header(reader, &entry);
  if (told == ARCHIVE_EOF) return nullptr;
  if (told < ARCHIVE_WARN || !entry) return fail(FaultKind::bad_input, "damaged: {}", words_of(reader));
  return entry;
}

// Passes on what the entry holds, `most` bytes of it. Errors: bad_input (more, or damaged); those of `take`.
template <class Take>
Result<> read_entry(archive* reader, std::uint64_t most, Take take) {
  std::vector<std::uint8_t> piece(kPiece);
  for (std::uint64_t done = 0;;) {
    const auto n = archive_read_data(reader, piece.data(), piece.size());
    if (n < 0) return fail(FaultKind::bad_input, "damaged: {}", words_of(reader));
    if (n == 0) return {};
    done += static_cast<std::uint64_t>(n);
    if (done > most) return fail(FaultKind::bad_input, "more than {} bytes", most);
    if (Result<> taken = take(std::span(piece.data(), static_cast<std::size_t>(n))); !taken) return taken;
  }
}

Result<std::string> entry_text(archive* reader, std::uint64_t most) {
  std::string text;
  auto read = read_entry(reader, most, [&](std::span<const std::uint8_t> piece) -> Result<> {
    text.append(reinterpret_cast<const char*>(piece.data()), piece.size());
    return {};
  });
  if (!read) return fail(read.error());
  return text;
}

std::string type_problem(archive_entry* entry) {
  if (archive_entry_hardlink(entry)) return "a link";
  switch (archive_entry_filetype(entry)) {
    case AE_IFREG: return archive_entry_size_is_set(entry) && archive_entry_size(entry) >= 0 ? "" : "of no size";
    case AE_IFLNK: return "a link";
    case AE_IFDIR: return "a folder by itself";
    case AE_IFCHR:
    case AE_IFBLK: return "a device";
    default: return "neither a file nor a folder";
  }
}

// All that a first look finds wrong, without counting beyond what helps.
class Findings {
 public:
  explicit Findings(const Bundle& bundle) : name_(bundle.path.string()) {}
  template <class... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    if (++count_ <= kMostProblems) problems_.add("{}: {}", name_, fmt::format(format, std::forward<Args>(args)...));
  }
  // Those of a reader that names a file itself.
  void add_lines(const std::string& lines) {
    for (std::size_t at = 0; at <= lines.size();) {
      const auto end = std::min(lines.find('\n', at), lines.size());
      add("{}", lines.substr(at, end - at));
      at = end + 1;
    }
  }
  bool empty() const { return count_ == 0; }
  bool enough() const { return count_ > kMostProblems; }
  Fault fault() {
    if (enough()) problems_.add("{}: and {} more", name_, count_ - kMostProblems);
    return problems_.fault();
  }

 private:
  std::string name_;
  Problems problems_;
  std::size_t count_ = 0;
};

void compare(const std::map<std::string, std::uint64_t>& found, const Manifest& manifest, Findings& findings) {
  std::set<std::string> named;
  for (const auto& file : manifest.files) {
    named.insert(file.path);
    const auto there = found.find(file.path);
    if (there == found.end())
      findings.add("{}: named by the manifest, but not there", file.path);
    else if (there->second != file.bytes)
      findings.add("{}: {} bytes, expected {}", file.path, there->second, file.bytes);
  }
  for (const auto& [path, bytes] : found)
    if (!named.contains(path)) findings.add("{}: not named by the manifest", path);
}

// A text of the bundle's own; whether the entry was one.
bool take_own_text(archive* reader, const std::string& path, Bundle& bundle, Findings& findings) {
  const bool manifest = path == kManifestName;
  if (!manifest && path != kSignatureName) return false;
  auto& to = manifest ? bundle.manifest_text : bundle.signature;
  if (!to.empty()) findings.add("{}: there twice", path);
  auto text = entry_text(reader, manifest ? kMostManifestBytes : kMostSignatureBytes);
  if (!text)
    findings.add("{}: {}", path, text.error().message);
  else
    to = std::move(*text);
  return true;
}

void look_at_entries(archive* reader, Bundle& bundle, Findings& findings) {
  std::map<std::string, std::uint64_t> found;
  std::uint64_t bytes = 0;
  std::size_t entries = 0;
  while (!findings.enough()) {
    const auto entry = next_entry(reader);
    if (!entry) return findings.add("{}", entry.error().message);
    if (!*entry) break;
    if (++entries > kMostFiles + 2) return findings.add("more than {} files", kMostFiles);
    const char* told = archive_entry_pathname(*entry);
    std::string path = told ? told : "";
    if (archive_entry_filetype(*entry) == AE_IFDIR && path.size() > 1 && path.ends_with('/')) path.pop_back();
    if (const auto problem = name_problem(path); !problem.empty()) {
      findings.add("{}", problem);
      continue;
    }
    if (const auto problem = type_problem(*entry); !problem.empty()) {
      findings.add("{}: {}, expected plain files alone", path, problem);
      continue;
    }
    if (take_own_text(reader, path, bundle, findings)) continue;
    const auto size = static_cast<std::uint64_t>(archive_entry_size(*entry));
    if (size > kMostFileBytes) findings.add("{}: {} bytes, expected at most {}", path, size, kMostFileBytes);
    if ((bytes += std::min(size, kMostBytes)) > kMostBytes)
      return findings.add("more than {} bytes in all", kMostBytes);
    if (!found.emplace(path, size).second) findings.add("{}: there twice", path);
  }
  if (bundle.manifest_text.empty()) return findings.add("no {}: not a bundle of `kasumi content pack`", kManifestName);
  auto manifest = parse_manifest(bundle.manifest_text);
  if (!manifest) return findings.add_lines(manifest.error().message);
  bundle.manifest = std::move(*manifest);
  compare(found, bundle.manifest, findings);
}

// Reads every file that the manifest names, and passes it on in pieces; `begin` is called before each, `end` after it.
template <class Begin, class Take, class End>
Result<> read_files(const Bundle& bundle, Begin begin, Take take, End end) {
  auto reader = open_archive(bundle);
  if (!reader) return fail(reader.error());
  std::map<std::string, const PackedFile*> missing;
  for (const auto& file : bundle.manifest.files) missing[file.path] = &file;
  Problems problems;
  const auto name = bundle.path.string();
  for (;;) {
    const auto entry = next_entry(reader->get());
    if (!entry) return fail(FaultKind::bad_input, "{}: {}", name, entry.error().message);
    if (!*entry) break;
    const char* path = archive_entry_pathname(*entry);
    const auto found = missing.find(path ? path : "");
    // What looking refused is not there now either, unless the file changes under our hands.
    if (found == missing.end() || !type_problem(*entry).empty()) continue;
    const PackedFile& file = *found->second;
    missing.erase(found);
    Sha256 hash;
    std::uint64_t bytes = 0;
    if (Result<> begun = begin(file); !begun) return begun;
    auto read = read_entry(reader->get(), file.bytes, [&](std::span<const std::uint8_t> piece) -> Result<> {
      hash.add(piece);
      bytes += piece.size();
      return take(piece);
    });
    if (!read && read.error().kind == FaultKind::io) return read;
    if (!read)
      problems.add("{}: {}: {}", name, file.path, read.error().message);
    else if (bytes != file.bytes || hash.hex() != file.sha256)
      problems.add("{}: {}: is not what the manifest names: damaged on the way?", name, file.path);
    if (Result<> ended = end(file); !ended) return ended;
  }
  for (const auto& [path, file] : missing) problems.add("{}: {}: is not there any more", name, path);
  if (!problems.empty()) return fail(problems.fault());
  return {};
}

Result<> write_all(int fd, std::span<const std::uint8_t> bytes, const std::string& name) {
  for (std::size_t done = 0; done < bytes.size();) {
    const auto n = ::write(fd, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return fail(FaultKind::io, "{}: cannot be written: {}", name, std::strerror(errno));
    done += static_cast<std::size_t>(n);
  }
  return {};
}

}  // namespace

Result<Bundle> look_into(const std::filesystem::path& path) {
  Bundle bundle;
  bundle.path = path;
  bundle.file = UniqueFd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat status {};
  if (!bundle.file || ::fstat(bundle.file.value(), &status) != 0)
    return fail(errno == EIO ? FaultKind::io : FaultKind::bad_input, "{}: cannot be read: {}", path.string(),
                std::strerror(errno));
  if (!S_ISREG(status.st_mode)) return fail(FaultKind::bad_input, "{}: expected a file", path.string());
  if (static_cast<std::uint64_t>(status.st_size) > kMostTarBytes)
    return fail(FaultKind::bad_input, "{}: {} bytes, expected at most {}", path.string(), status.st_size,
                kMostTarBytes);
  const auto reader = open_archive(bundle);
  if (!reader) return fail(reader.error());
  Findings findings(bundle);
  look_at_entries(reader->get(), bundle, findings);
  if (!findings.empty()) return fail(findings.fault());
  return bundle;
}

Result<> check_files(const Bundle& bundle) {
  const auto nothing = [](const auto&) -> Result<> { return {}; };
  return read_files(bundle, nothing, nothing, nothing);
}

Result<> check_unpacked(const fs::path& folder, const Manifest& manifest) {
  Problems problems;
  for (const auto& file : manifest.files)
    if (const auto hash = sha256_of_file(folder / file.path); !hash)
      problems.add("{}", hash.error().message);
    else if (*hash != file.sha256)
      problems.add("{}: is not what the manifest names: damaged since", (folder / file.path).string());
  if (!problems.empty()) return fail(problems.fault());
  return {};
}

Result<> unpack(const Bundle& bundle, const fs::path& folder) {
  UniqueFd file;
  std::string name;
  std::set<fs::path> folders{folder};
  const auto begin = [&](const PackedFile& packed) -> Result<> {
    const auto path = folder / packed.path;
    name = path.string();
    if (auto made = create_folders(path.parent_path()); !made) return made;
    folders.insert(path.parent_path());
    file = UniqueFd(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644));
    if (!file) return fail(FaultKind::io, "{}: cannot be written: {}", name, std::strerror(errno));
    return {};
  };
  const auto take = [&](std::span<const std::uint8_t> piece) { return write_all(file.value(), piece, name); };
  const auto end = [&](const PackedFile&) -> Result<> {
    if (::fsync(file.value()) != 0) return fail(FaultKind::io, "{}: cannot be written: {}", name, std::strerror(errno));
    file = UniqueFd();
    return {};
  };
  if (auto read = read_files(bundle, begin, take, end); !read) return read;
  for (const auto& each : folders)
    if (auto written = write_through_names(each); !written) return written;
  if (auto written = write_text_file(folder / kManifestName, bundle.manifest_text); !written) return written;
  if (bundle.signature.empty()) return {};
  return write_text_file(folder / kSignatureName, bundle.signature);
}

}  // namespace kasumi
