#include "capture/payload_cache.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/unique_fd.hpp"

namespace kasumi {

namespace {

constexpr std::size_t kMostKept = 8;

// The smaller of what the file holds and what the index says is allocated, so that neither can ask for more than there
// is.
Result<std::vector<std::uint8_t>> read_at_most(const std::filesystem::path& path, std::uint32_t limit) {
  const UniqueFd fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  struct stat status {};
  if (!fd || ::fstat(fd.value(), &status) != 0)
    return fail(FaultKind::io, "{}: cannot be read: {}", path.string(), std::strerror(errno));
  if (!S_ISREG(status.st_mode)) return fail(FaultKind::io, "{}: expected a file", path.string());
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(std::min<std::int64_t>(status.st_size, limit)));
  std::size_t done = 0;
  while (done < bytes.size()) {
    const auto n = ::read(fd.value(), bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return fail(FaultKind::io, "{}: reading failed: {}", path.string(), std::strerror(errno));
    if (n == 0) break;  // shortened meanwhile
    done += static_cast<std::size_t>(n);
  }
  bytes.resize(done);
  return bytes;
}

}  // namespace

Result<Payload> PayloadCache::read(const std::string& name, std::uint32_t bytes_used, bool keep) {
  if (name.empty() || bytes_used == 0) return Payload{};
  const auto same = [&](const Entry& entry) { return entry.name == name && entry.bytes_used == bytes_used; };
  if (const auto found = std::find_if(kept_.begin(), kept_.end(), same); found != kept_.end()) {
    std::rotate(kept_.begin(), found, found + 1);
    return kept_.front().payload;
  }
  auto bytes = read_at_most(folder_ / name, bytes_used);
  if (!bytes) return fail(bytes.error());
  Payload payload = payload_of(std::move(*bytes));
  if (keep) {
    kept_.push_front({name, bytes_used, payload});
    if (kept_.size() > kMostKept) kept_.pop_back();
  }
  return payload;
}

}  // namespace kasumi
