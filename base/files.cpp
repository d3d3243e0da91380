#include "base/files.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/unfinished_file.hpp"
#include "base/unique_fd.hpp"

namespace kasumi {

namespace {

constexpr std::size_t kReadChunk = 1 << 16;  // for files that report no size: pipes, /proc

// What a person can correct is bad input; the rest is the disk's, the memory's or the system's fault, and may pass.
FaultKind kind_of(int error) {
  switch (error) {
    case ENOENT:
    case ENOTDIR:
    case EISDIR:
    case EACCES:
    case EPERM:
    case ELOOP:
    case ENAMETOOLONG:
    case EINVAL: return FaultKind::bad_input;
    default: return FaultKind::io;
  }
}

tl::unexpected<Fault> cannot_read(const std::filesystem::path& path, int error) {
  if (error == EISDIR) return fail(FaultKind::bad_input, "{}: is a folder, expected a file", path.string());
  return fail(kind_of(error), "{}: cannot be read: {}", path.string(), std::strerror(error));
}

tl::unexpected<Fault> too_large(const std::filesystem::path& path, const ReadBounds& bounds) {
  return fail(FaultKind::bad_input, "{}: larger than {} bytes, the most expected", path.string(), bounds.most_bytes);
}

// A reader of a pipe would wait for its writer in open() already.
UniqueFd open_to_read(const std::filesystem::path& path, const ReadBounds& bounds) {
  return UniqueFd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY | (bounds.or_pipe ? 0 : O_NONBLOCK)));
}

}  // namespace

// Not through a stream: its iterators throw where the disk cannot read, and hide why.
Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& path, const ReadBounds& bounds) try {
  const UniqueFd fd = open_to_read(path, bounds);
  if (!fd) return cannot_read(path, errno);
  struct stat status {};
  if (::fstat(fd.value(), &status) != 0) return cannot_read(path, errno);
  if (S_ISDIR(status.st_mode)) return cannot_read(path, EISDIR);
  if (!S_ISREG(status.st_mode) && !bounds.or_pipe)
    return fail(FaultKind::bad_input, "{}: is a {}, expected a file", path.string(),
                S_ISFIFO(status.st_mode) ? "pipe" : "device");
  const auto told = S_ISREG(status.st_mode) ? static_cast<std::uintmax_t>(status.st_size) : 0;
  if (told > bounds.most_bytes) return too_large(path, bounds);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(told) + 1);  // one more, to see the end
  for (std::size_t done = 0;;) {
    if (done > bounds.most_bytes) return too_large(path, bounds);
    if (done == bytes.size()) bytes.resize(std::max(2 * done, done + kReadChunk));
    const auto n = ::read(fd.value(), bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return cannot_read(path, errno);
    done += static_cast<std::size_t>(n);
    if (n > 0) continue;
    bytes.resize(done);
    return bytes;
  }
} catch (const std::bad_alloc&) {
  return cannot_read(path, ENOMEM);
}

Result<std::string> read_text_file(const std::filesystem::path& path, const ReadBounds& bounds) {
  return read_file(path, bounds).map([](const std::vector<std::uint8_t>& bytes) {
    return std::string(bytes.begin(), bytes.end());
  });
}

Result<> replace_file(const std::filesystem::path& path,
                      const std::function<Result<>(const std::filesystem::path&)>& write) {
  const auto unfinished = unfinished_name(path);
  if (auto written = write(unfinished); !written) {
    std::error_code ignored;
    std::filesystem::remove(unfinished, ignored);
    return written;
  }
  return finish_file(unfinished, path);
}

Result<> write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  return replace_file(path, [&](const std::filesystem::path& unfinished) -> Result<> {
    const UniqueFd fd(::open(unfinished.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644));
    if (!fd) return fail(FaultKind::io, "{}: cannot be written: {}", path.string(), std::strerror(errno));
    for (std::size_t done = 0; done < bytes.size();) {
      const auto n = ::write(fd.value(), bytes.data() + done, bytes.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return fail(FaultKind::io, "{}: writing failed: {}", path.string(), std::strerror(errno));
      done += static_cast<std::size_t>(n);
    }
    return {};
  });
}

Result<> write_text_file(const std::filesystem::path& path, std::string_view text) {
  return write_file(path, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

}  // namespace kasumi
