#include "report/web/arriving_bundle.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/files.hpp"
#include "base/unfinished_file.hpp"

namespace kasumi::report {

namespace {

namespace fs = std::filesystem;

std::optional<PullNote> note_in(const fs::path& file, const std::string& url) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return std::nullopt;
  auto note = parse_pull_note(read_text_file(file).value_or(""));
  return note && note->url == url ? note : std::nullopt;
}

Result<> cannot_write(const fs::path& file) {
  return fail(FaultKind::io, "{}: cannot be written: {}", file.string(), std::strerror(errno));
}

}  // namespace

ArrivingBundle::ArrivingBundle(fs::path folder, const std::string& url, std::uint64_t left_free, std::uint64_t sync,
                               FreeBytes free_bytes)
    : folder_(std::move(folder)), left_free_(left_free), sync_(sync), free_bytes_(std::move(free_bytes)) {
  std::error_code error;
  whole_.url = part_.url = url;
  if (const auto whole = note_in(folder_ / "fetched.txt", url);
      whole && fs::file_size(folder_ / "content/fetched.kasumi", error) == whole->bytes && !error)
    whole_ = *whole;
  if (const auto part = note_in(folder_ / "arriving.txt", url))
    if (const auto size = fs::file_size(folder_ / "arriving.part", error); !error && size >= part->bytes) {
      part_ = *part;
      bytes_ = part->bytes;
    }
  if (part_.tag.empty()) forget();
  // The unit that waits for it may have been cut off before it looked: the new time triggers it again.
  if (!whole_.tag.empty()) ::utimensat(AT_FDCWD, (folder_ / "content/fetched.kasumi").c_str(), nullptr, 0);
}

Result<> ArrivingBundle::fits(std::uint64_t more) const {
  const auto left = free_bytes_(folder_);
  if (!left) return fail(left.error());
  if (more + left_free_ <= *left) return {};
  return fail(FaultKind::io, "{}: {} MB of the disk are free, and {} MB are needed", folder_.string(), *left >> 20,
              (more + left_free_) >> 20);
}

Result<> ArrivingBundle::begin(std::string tag, std::uint64_t all) {
  forget();
  if (auto made = create_folders(folder_); !made) return made;
  if (auto room = fits(all); !room) return room;
  const auto path = folder_ / "arriving.part";
  file_ = UniqueFd(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0644));
  if (!file_) return cannot_write(path);
  part_.tag = std::move(tag);
  return write_through();
}

// Beyond what was synced lies what a power cut made of it.
Result<> ArrivingBundle::resume(std::uint64_t all) {
  if (auto room = fits(all - std::min(all, part_.bytes)); !room) return room;
  const auto path = folder_ / "arriving.part";
  file_ = UniqueFd(::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW));
  const auto at = static_cast<off_t>(part_.bytes);
  if (!file_ || ::ftruncate(file_.value(), at) != 0 || ::lseek(file_.value(), at, SEEK_SET) != at)
    return cannot_write(path);
  bytes_ = part_.bytes;
  return {};
}

Result<> ArrivingBundle::add(std::span<const char> piece) {
  const auto path = folder_ / "arriving.part";
  while (!piece.empty()) {
    const auto n = ::write(file_.value(), piece.data(), piece.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return cannot_write(path);
    bytes_ += static_cast<std::uint64_t>(n);
    piece = piece.subspan(static_cast<std::size_t>(n));
  }
  if (bytes_ - part_.bytes < sync_) return {};
  if (auto room = fits(0); !room) return room;
  return write_through();
}

Result<> ArrivingBundle::write_through() {
  if (::fdatasync(file_.value()) != 0) return cannot_write(folder_ / "arriving.part");
  part_.bytes = bytes_;
  return write_text_file(folder_ / "arriving.txt", text_of(part_));
}

void ArrivingBundle::keep() {
  if (file_) (void)write_through();
  file_ = UniqueFd();
}

Result<> ArrivingBundle::finish() {
  if (auto synced = write_through(); !synced) return synced;
  file_ = UniqueFd();
  const auto content = folder_ / "content";
  if (auto made = create_folders(content); !made) return made;
  if (::rename((folder_ / "arriving.part").c_str(), (content / "fetched.kasumi").c_str()) != 0)
    return cannot_write(content / "fetched.kasumi");
  if (auto named = write_through_names(content); !named) return named;
  // Noted afterwards: if the power goes in between, it comes once more.
  if (auto noted = write_text_file(folder_ / "fetched.txt", text_of(part_)); !noted) return noted;
  whole_ = part_;
  forget();
  return {};
}

void ArrivingBundle::forget() {
  std::error_code ignored;
  file_ = UniqueFd();
  fs::remove(folder_ / "arriving.txt", ignored);
  fs::remove(folder_ / "arriving.part", ignored);
  part_.tag.clear();
  part_.bytes = bytes_ = 0;
}

}  // namespace kasumi::report
