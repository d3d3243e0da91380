#include "pipeline/lab/archive/part_file.hpp"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/unfinished_file.hpp"
#include "pipeline/lab/archive/record_lines.hpp"

namespace kasumi {
namespace {

constexpr std::size_t kBlock = 64;  // records between writes through to the disk: a second or two of work

tl::unexpected<Fault> cannot_write(const std::filesystem::path& path) {
  return fail(FaultKind::io, "{}: cannot be written: {}", path.string(), std::strerror(errno));
}

}  // namespace

Result<PartFile> PartFile::open(const std::filesystem::path& path, const PartPlan& plan, bool resume) {
  UniqueFd fd(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_APPEND, 0666));
  if (!fd) return fail(FaultKind::bad_input, "--out {}: cannot be written: {}", path.string(), std::strerror(errno));
  struct stat status {};
  if (::fstat(fd.value(), &status) != 0) return cannot_write(path);
  if (!S_ISREG(status.st_mode)) return fail(FaultKind::bad_input, "--out {}: expected a file", path.string());
  // A task that was requeued may start before its first run is dead. Some file systems have no locks.
  if (::flock(fd.value(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    return fail(FaultKind::bad_input, "--out {}: another process writes it", path.string());
  PartFile part(path, std::move(fd));
  if (status.st_size > 0 && !resume)
    return fail(FaultKind::bad_input, "--out {}: is there already, expected --resume to go on with it, or another name",
                path.string());
  if (auto resumed = part.resume(plan); !resumed) return fail(resumed.error());
  if (auto named = write_through_names(path.has_parent_path() ? path.parent_path() : "."); !named)
    return fail(named.error());
  return part;
}

Result<> PartFile::resume(const PartPlan& plan) {
  RecordLines lines(path_);
  std::uint64_t whole = 0;
  while (lines.next()) {
    const auto place = lines.whole() ? place_in(lines.line()) : std::nullopt;
    if (!place && done_ == 0 && lines.whole() && lines.line().find('\0') == std::string_view::npos)
      return fail(FaultKind::bad_input, "--out {}: expected records of `kasumi estimate --out`, or a new file",
                  path_.string());
    if (!place) break;  // torn
    const auto wrong = [&](const char* what) {
      return fail(FaultKind::bad_input, "--out {}: line {} is of {}: expected another file, or what it was begun with",
                  path_.string(), done_ + 1, what);
    };
    if (place->archive.pictures != plan.archive.pictures || place->archive.list != plan.archive.list)
      return wrong("another list of pictures");
    if (place->archive.options != plan.archive.options) return wrong("other options");
    if (done_ >= plan.count || place->picture != plan.first + done_ + 1) return wrong("another shard");
    ++done_;
    whole = lines.end();
  }
  struct stat status {};
  if (::fstat(file_.value(), &status) != 0) return cannot_write(path_);
  mended_ = static_cast<std::size_t>(status.st_size) - whole;
  if (mended_ > 0 && ::ftruncate(file_.value(), static_cast<off_t>(whole)) != 0) return cannot_write(path_);
  return {};
}

Result<> PartFile::add(std::string_view line) {
  while (!line.empty()) {
    const auto written = ::write(file_.value(), line.data(), line.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return cannot_write(path_);
    line.remove_prefix(static_cast<std::size_t>(written));
  }
  return ++unsynced_ < kBlock ? Result<>() : finish();
}

Result<> PartFile::finish() {
  unsynced_ = 0;
  if (::fdatasync(file_.value()) != 0) return cannot_write(path_);
  return {};
}

}  // namespace kasumi
