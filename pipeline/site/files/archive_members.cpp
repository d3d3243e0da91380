#include "pipeline/site/files/archive_members.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <climits>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string_view>
#include <utility>

#include <archive.h>
#include <archive_entry.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/c_ptr.hpp"
#include "base/files.hpp"
#include "base/unique_fd.hpp"

namespace kasumi {
namespace {

constexpr std::array<std::string_view, 9> kArchiveEndings{".tar",     ".tar.gz", ".tgz",     ".tar.xz", ".txz",
                                                          ".tar.bz2", ".tbz2",   ".tar.zst", ".zip"};

bool ends_as_archive(std::string_view name) {
  constexpr std::size_t kLongest = 8;
  std::string end(name.substr(name.size() - std::min(name.size(), kLongest)));
  std::ranges::transform(end, end.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::ranges::any_of(kArchiveEndings, [&](std::string_view ending) { return end.ends_with(ending); });
}

// One pass over an archive, from its begin, or over a plain tar from the header of a member.
class MembersPass {
 public:
  static Result<MembersPass> open(const std::filesystem::path& path, std::int64_t from = 0) {
    constexpr std::size_t kPiece = 1 << 14;  // what a step over a member of a plain tar reads
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error))
      return fail(FaultKind::bad_input, "{}: no such archive", path.string());
    MembersPass pass(path, from);
    auto* reader = pass.reader_.get();
    if (!reader) return fail(FaultKind::io, "not enough memory");
    archive_read_support_format_tar(reader);
    archive_read_support_format_zip(reader);
    archive_read_support_filter_gzip(reader);
    archive_read_support_filter_bzip2(reader);
    archive_read_support_filter_xz(reader);
    archive_read_support_filter_zstd(reader);
    pass.file_ = UniqueFd(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (!pass.file_ || (from > 0 && ::lseek(pass.file_.value(), from, SEEK_SET) != from))
      return fail(FaultKind::bad_input, "{}: cannot be read: {}", path.string(), std::strerror(errno));
    if (archive_read_open_fd(reader, pass.file_.value(), kPiece) != ARCHIVE_OK) return fail(pass.damage());
    return pass;
  }

  const std::filesystem::path& path() const { return path_; }
  // Of the member whose name came last.
  std::int64_t header_at() const { return from_ + archive_read_header_position(reader_.get()); }
  bool is_plain_tar() const {
    return archive_filter_count(reader_.get()) == 1 &&
           (archive_format(reader_.get()) & ARCHIVE_FORMAT_BASE_MASK) == ARCHIVE_FORMAT_TAR;
  }
  // The same, as its header has it.
  std::int64_t size() const { return size_; }
  bool is_compressed() const { return archive_filter_count(reader_.get()) > 1; }

  // The next file's name; empty: the archive has ended.
  Result<std::string> next() {
    for (;;) {
      archive_entry* entry = nullptr;
      const int status = archive_read_next_header(reader_.get(), &entry);
      if (status == ARCHIVE_EOF) return std::string();
      if (status < ARCHIVE_WARN || !entry) return fail(damage());  // libarchive has read what it only warns of
      if (archive_entry_filetype(entry) != AE_IFREG || archive_entry_hardlink(entry)) continue;
      const char* name = archive_entry_pathname_utf8(entry);
      if (!name) name = archive_entry_pathname(entry);
      if (!name || *name == '\0') continue;
      size_ = archive_entry_size_is_set(entry) ? archive_entry_size(entry) : 0;
      if (std::string_view(name).size() >= PATH_MAX)
        return fail(FaultKind::bad_input, "{}: a member's name has more than {} bytes", path_.string(), PATH_MAX - 1);
      return std::string(name);
    }
  }

  // What the member holds whose name came last. The size that its header has is not believed.
  Result<std::vector<std::uint8_t>> read(const std::string& name) {
    constexpr std::size_t kPiece = 1 << 20;
    std::vector<std::uint8_t> bytes;
    for (;;) {
      const auto done = bytes.size();
      bytes.resize(done + kPiece);
      const auto count = archive_read_data(reader_.get(), bytes.data() + done, kPiece);
      if (count < 0) return fail(FaultKind::bad_input, "{}:{}: {}", path_.string(), name, words());
      bytes.resize(done + static_cast<std::size_t>(count));
      if (count == 0) return bytes;
      if (bytes.size() > kMostMemberBytes)
        return fail(FaultKind::bad_input, "{}:{}: more than {} bytes", path_.string(), name, kMostMemberBytes);
    }
  }

 private:
  MembersPass(std::filesystem::path path, std::int64_t from)
      : path_(std::move(path)), from_(from), reader_(archive_read_new()) {}
  std::string words() const {
    const char* words = archive_error_string(reader_.get());
    return words ? words : "damaged";
  }
  Fault damage() const {
    return {FaultKind::bad_input, fmt::format("{}: cannot be read as tar or zip: {}", path_.string(), words())};
  }

  std::filesystem::path path_;
  std::int64_t from_, size_ = 0;
  UniqueFd file_;
  CPtr<archive, archive_read_free> reader_;
};

using Bytes = std::vector<std::uint8_t>;

// Which file stands under a name: it may have been replaced since.
struct FileIdentity {
  std::filesystem::path path;
  dev_t device = 0;
  ino_t inode = 0;
  off_t size = 0;
  std::int64_t changed_ns = 0;
  bool operator==(const FileIdentity&) const = default;

  static FileIdentity of(const std::filesystem::path& path) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return {path};
    return {path, status.st_dev, status.st_ino, status.st_size,
            std::int64_t{1'000'000'000} * status.st_mtim.tv_sec + status.st_mtim.tv_nsec};
  }
};

tl::unexpected<Fault> not_there(const ArchiveMember& member) {
  return fail(FaultKind::bad_input, "{}: has no member {}", member.archive.string(), member.name);
}

// A compressed tar, which has no places to go to.
class CompressedArchive {
 public:
  // `kept`: it is asked for once more, whole.
  Result<Bytes> read(const ArchiveMember& member, bool kept) {
    const std::scoped_lock lock(mutex_);
    if (const auto before = kept_.find(member.name); before != kept_.end()) return kept ? before->second : take(before);
    bool from_begin = false;
    for (;;) {
      if (!pass_) {
        auto opened = MembersPass::open(member.archive);
        if (!opened) return fail(opened.error());
        pass_.emplace(std::move(*opened));
        from_begin = true;
      }
      auto name = pass_->next();
      if (!name || name->empty()) {
        pass_.reset();
        if (!from_begin) continue;
        return name ? Result<Bytes>(not_there(member)) : fail(name.error());
      }
      const bool wanted = *name == member.name;
      if (!wanted && pass_->size() > static_cast<std::int64_t>(kMostKept / 4)) continue;
      auto bytes = pass_->read(*name);
      if (!bytes) {
        pass_.reset();
        if (wanted || from_begin) return fail(bytes.error());
        continue;
      }
      if (!wanted || kept) keep(*name, *bytes);
      if (wanted) return bytes;
    }
  }

 private:
  void keep(const std::string& name, const Bytes& bytes) {
    if (bytes.size() > kMostKept / 4 || !kept_.emplace(name, bytes).second) return;
    order_.push_back(name);
    for (kept_bytes_ += bytes.size(); kept_bytes_ > kMostKept; order_.pop_front())
      if (const auto oldest = kept_.find(order_.front()); oldest != kept_.end()) take(oldest);
  }
  Bytes take(std::map<std::string, Bytes>::iterator at) {
    auto bytes = std::move(at->second);
    kept_bytes_ -= bytes.size();
    kept_.erase(at);
    return bytes;
  }

  std::mutex mutex_;
  std::optional<MembersPass> pass_;
  std::map<std::string, Bytes> kept_;
  std::deque<std::string> order_;  // of kept_, the oldest first, with some that were taken
  std::size_t kept_bytes_ = 0;
};

// The compressed archives that were read last: neighbours in a list may be of two.
class CompressedArchives {
 public:
  // Null: none of them.
  std::shared_ptr<CompressedArchive> of(const FileIdentity& file) {
    const std::scoped_lock lock(mutex_);
    const auto found = std::ranges::find(last_, file, &Named::first);
    return found == last_.end() ? nullptr : found->second;
  }
  std::shared_ptr<CompressedArchive> add(const FileIdentity& file) {
    constexpr std::size_t kOpen = 2;
    const std::scoped_lock lock(mutex_);
    const auto found = std::ranges::find(last_, file, &Named::first);
    if (found != last_.end()) return found->second;
    if (last_.size() == kOpen) last_.pop_front();
    return last_.emplace_back(file, std::make_shared<CompressedArchive>()).second;
  }

 private:
  using Named = std::pair<FileIdentity, std::shared_ptr<CompressedArchive>>;
  std::mutex mutex_;
  std::deque<Named> last_;
};

// What a thread has open, and of a plain tar that was read out of its order, where members begin.
struct Passing {
  FileIdentity file;
  std::optional<MembersPass> pass;
  bool has_places = false;
  std::map<std::string, std::int64_t> places;
};

Result<Bytes> read_member(const ArchiveMember& member, bool kept) {
  constexpr std::size_t kMostPlaces = 1'000'000;
  static CompressedArchives compressed;
  thread_local Passing passing;
  const auto file = FileIdentity::of(member.archive);
  if (const auto archive = compressed.of(file)) return archive->read(member, kept);
  auto& pass = passing.pass;
  if (passing.file != file) passing = {file, {}, false, {}};
  bool from_begin = false;
  if (const auto place = passing.places.find(member.name); place != passing.places.end()) {
    auto opened = MembersPass::open(member.archive, place->second);
    if (!opened) return fail(opened.error());
    pass.emplace(std::move(*opened));
  }
  for (;;) {
    if (!pass) {
      auto opened = MembersPass::open(member.archive);
      if (!opened) return fail(opened.error());
      pass.emplace(std::move(*opened));
      from_begin = true;
    }
    auto name = pass->next();
    if (pass->is_compressed()) {
      pass.reset();
      return compressed.add(file)->read(member, kept);
    }
    if (name && !name->empty() && passing.has_places && passing.places.size() < kMostPlaces && pass->is_plain_tar())
      passing.places.emplace(*name, pass->header_at());
    if (name && *name == member.name) {
      auto bytes = pass->read(*name);
      if (!bytes) pass.reset();
      return bytes;
    }
    if (name && !name->empty()) continue;
    pass.reset();
    if (from_begin) return name ? Result<Bytes>(not_there(member)) : fail(name.error());
    passing.has_places = true;
  }
}

}  // namespace

bool is_archive_file(const std::filesystem::path& path) {
  return ends_as_archive(path.native());
}

std::optional<ArchiveMember> archive_member(const std::filesystem::path& path) {
  const auto& text = path.native();
  for (auto colon = text.find(':'); colon != std::string::npos; colon = text.find(':', colon + 1)) {
    if (colon + 1 == text.size() || !ends_as_archive(std::string_view(text).substr(0, colon))) continue;
    std::error_code error;
    if (std::filesystem::exists(path, error)) return std::nullopt;
    return ArchiveMember{text.substr(0, colon), text.substr(colon + 1)};
  }
  return std::nullopt;
}

Result<std::vector<std::string>> members_of(const std::filesystem::path& archive) {
  auto pass = MembersPass::open(archive);
  if (!pass) return fail(pass.error());
  std::vector<std::string> names;
  for (;;) {
    auto name = pass->next();
    if (!name) return fail(name.error());
    if (name->empty()) return names;
    if (names.size() == kMostMembers)
      return fail(FaultKind::bad_input, "{}: more than {} members", archive.string(), kMostMembers);
    names.push_back(std::move(*name));
  }
}

Result<std::vector<std::uint8_t>> read_picture_bytes(const std::filesystem::path& path, std::size_t most) {
  const auto member = archive_member(path);
  if (member) return read_member(*member, most < SIZE_MAX);
  if (most == SIZE_MAX) return read_file(path);
  std::error_code error;
  const UniqueFd file(std::filesystem::is_regular_file(path, error) ? ::open(path.c_str(), O_RDONLY | O_CLOEXEC) : -1);
  Bytes bytes(most);
  const auto count = file ? ::read(file.value(), bytes.data(), most) : -1;
  if (count < 0) return fail(FaultKind::bad_input, "{}: cannot be read", path.string());
  bytes.resize(static_cast<std::size_t>(count));
  return bytes;
}

}  // namespace kasumi
