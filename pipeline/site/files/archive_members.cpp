#include "pipeline/site/files/archive_members.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <climits>
#include <string_view>

#include <archive.h>
#include <archive_entry.h>

#include "base/c_ptr.hpp"
#include "base/files.hpp"

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

// One pass over an archive, from its begin.
class MembersPass {
 public:
  static Result<MembersPass> open(const std::filesystem::path& path) {
    constexpr std::size_t kPiece = 1 << 16;
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error))
      return fail(FaultKind::bad_input, "{}: no such archive", path.string());
    MembersPass pass(path);
    auto* reader = pass.reader_.get();
    if (!reader) return fail(FaultKind::io, "not enough memory");
    archive_read_support_format_tar(reader);
    archive_read_support_format_zip(reader);
    archive_read_support_filter_gzip(reader);
    archive_read_support_filter_bzip2(reader);
    archive_read_support_filter_xz(reader);
    archive_read_support_filter_zstd(reader);
    if (archive_read_open_filename(reader, path.c_str(), kPiece) != ARCHIVE_OK) return fail(pass.damage());
    return pass;
  }

  const std::filesystem::path& path() const { return path_; }

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
  explicit MembersPass(std::filesystem::path path) : path_(std::move(path)), reader_(archive_read_new()) {}
  std::string words() const {
    const char* words = archive_error_string(reader_.get());
    return words ? words : "damaged";
  }
  Fault damage() const {
    return {FaultKind::bad_input, fmt::format("{}: cannot be read as tar or zip: {}", path_.string(), words())};
  }

  std::filesystem::path path_;
  CPtr<archive, archive_read_free> reader_;
};

Result<std::vector<std::uint8_t>> read_member(const ArchiveMember& member) {
  thread_local std::optional<MembersPass> pass;
  bool from_begin = false;
  if (!pass || pass->path() != member.archive) pass.reset();
  for (;;) {
    if (!pass) {
      auto opened = MembersPass::open(member.archive);
      if (!opened) return fail(opened.error());
      pass.emplace(std::move(*opened));
      from_begin = true;
    }
    auto name = pass->next();
    if (name && *name == member.name) {
      auto bytes = pass->read(*name);
      if (!bytes) pass.reset();
      return bytes;
    }
    if (name && !name->empty()) continue;
    pass.reset();
    if (from_begin)
      return name ? fail(FaultKind::bad_input, "{}: has no member {}", member.archive.string(), member.name)
                  : fail(name.error());
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

Result<std::vector<std::uint8_t>> read_picture_bytes(const std::filesystem::path& path) {
  const auto member = archive_member(path);
  return member ? read_member(*member) : read_file(path);
}

}  // namespace kasumi
