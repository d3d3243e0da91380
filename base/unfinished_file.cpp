#include "base/unfinished_file.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <mutex>
#include <optional>
#include <set>

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/unique_fd.hpp"

namespace kasumi {

namespace {

std::filesystem::path folder_of(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

// The process that was writing ".STEM.RANDOM.PID.part.EXT"; empty for any other name.
std::optional<pid_t> writer_of(const std::string& name) {
  const auto part = name.rfind(".part");
  if (!name.starts_with('.') || part == std::string::npos || part == 0) return std::nullopt;
  const auto end = part + std::strlen(".part");
  if (end < name.size() && name[end] != '.') return std::nullopt;
  const auto dot = name.rfind('.', part - 1);
  if (dot == std::string::npos || dot == 0) return std::nullopt;
  pid_t writer = 0;
  const auto [rest, error] = std::from_chars(name.data() + dot + 1, name.data() + part, writer);
  if (error != std::errc() || rest != name.data() + part || writer <= 0) return std::nullopt;
  return writer;
}

// Under this process's own number it is of an earlier boot, since this one has not written here yet.
bool is_leftover(const std::filesystem::directory_entry& entry) {
  std::error_code error;
  const auto writer = writer_of(entry.path().filename().string());
  if (!writer || !std::filesystem::is_regular_file(entry.symlink_status(error))) return false;
  return *writer == ::getpid() || (::kill(*writer, 0) != 0 && errno == ESRCH);
}

void sweep(const std::filesystem::path& folder) {
  std::error_code error;
  for (auto entry = std::filesystem::directory_iterator(folder, error); !error && entry != end(entry);
       entry.increment(error)) {
    std::error_code ignored;
    if (is_leftover(*entry)) std::filesystem::remove(entry->path(), ignored);
  }
}

void sweep_once(const std::filesystem::path& folder) {
  static std::mutex mutex;
  static std::set<std::pair<dev_t, ino_t>> swept;
  struct stat status {};
  if (::stat(folder.c_str(), &status) != 0) return;
  const std::lock_guard lock(mutex);
  if (swept.emplace(status.st_dev, status.st_ino).second) sweep(folder);
}

// So that no other account can put a link there first, in a folder that several accounts write to.
std::uint32_t unguessable() {
  static std::atomic<std::uint32_t> count = 0;  // where the kernel has no random numbers yet
  std::uint32_t random = 0;
  if (::getrandom(&random, sizeof random, GRND_NONBLOCK) != sizeof random) random = ++count;
  return random;
}

// What was written to it is on the disk on return.
Result<> write_through(const std::filesystem::path& file) {
  const UniqueFd fd(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  if (!fd || ::fsync(fd.value()) != 0) return fail(FaultKind::io, "{}", std::strerror(errno));
  return {};
}

}  // namespace

std::filesystem::path unfinished_name(const std::filesystem::path& path) {
  sweep_once(folder_of(path));
  const auto name = path.filename();
  return path.parent_path() / fmt::format(".{}.{:08x}.{}.part{}", name.stem().string(), unguessable(), ::getpid(),
                                          name.extension().string());
}

Result<> finish_file(const std::filesystem::path& unfinished, const std::filesystem::path& path) {
  // The data must be on the disk before the name is, or a power cut leaves an empty file under it.
  auto done = write_through(unfinished);
  if (done && ::rename(unfinished.c_str(), path.c_str()) != 0) done = fail(FaultKind::io, "{}", std::strerror(errno));
  if (!done) {
    std::error_code ignored;
    std::filesystem::remove(unfinished, ignored);
    return fail(FaultKind::io, "{}: cannot be written: {}", path.string(), done.error().message);
  }
  // So must the name, because another file may refer to it and must still find it after a power cut.
  return write_through_names(folder_of(path));
}

Result<> write_through_names(const std::filesystem::path& folder) {
  const UniqueFd fd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  // Some folders may not be read, and some file systems cannot do this for folders: then there is no more to be done.
  const bool possible = fd || errno != EACCES;
  if (!possible || (fd && ::fsync(fd.value()) == 0) || (fd && (errno == EINVAL || errno == ENOTSUP))) return {};
  return fail(FaultKind::io, "{}: writing failed: {}", folder.string(), std::strerror(errno));
}

}  // namespace kasumi
