#include "capture/v4l2/video_device.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <utility>

#include "base/unique_fd.hpp"

namespace kasumi {

namespace {

class SystemVideoDevice final : public VideoDevice {
 public:
  explicit SystemVideoDevice(UniqueFd fd) : fd_(std::move(fd)) {}

  int control(unsigned long request, void* argument) override {
    for (int tries = 0; tries < 100; ++tries) {
      if (::ioctl(fd_.value(), request, argument) == 0) return 0;
      if (errno != EINTR) return errno;
    }
    return EINTR;
  }

  VideoEvents wait(Duration longest) override {
    const auto nanoseconds = std::max(longest, Duration::zero()).count();
    const timespec timeout{nanoseconds / 1'000'000'000, nanoseconds % 1'000'000'000};
    pollfd entry{fd_.value(), POLLIN | POLLPRI, 0};
    const int ready = ::ppoll(&entry, 1, &timeout, nullptr);
    if (ready < 0) return {.error = errno != EINTR};
    const auto has = [&](int events) { return (entry.revents & events) != 0; };
    return {.readable = has(POLLIN), .event = has(POLLPRI), .error = has(POLLERR | POLLHUP | POLLNVAL)};
  }

  std::span<const std::uint8_t> map(std::size_t length, std::int64_t offset, int& error) override {
    void* memory = ::mmap(nullptr, length, PROT_READ, MAP_SHARED, fd_.value(), offset);
    error = memory == MAP_FAILED ? errno : 0;
    if (error != 0) return {};
    return {static_cast<const std::uint8_t*>(memory), length};
  }

  void unmap(std::span<const std::uint8_t> mapped) override {
    ::munmap(const_cast<std::uint8_t*>(mapped.data()), mapped.size());
  }

 private:
  UniqueFd fd_;
};

// The number of "video12"; empty for other names.
std::optional<int> video_number(const std::filesystem::path& path) {
  const auto name = path.filename().string();
  if (!name.starts_with("video")) return std::nullopt;
  int number = 0;
  const auto* end = name.data() + name.size();
  const auto [rest, error] = std::from_chars(name.data() + 5, end, number);
  if (error != std::errc{} || rest != end) return std::nullopt;
  return number;
}

}  // namespace

Fault device_fault(int error, std::string_view call) {
  switch (error) {
    case ENODEV:
    case ENXIO:
    case ENOENT:
    case ESHUTDOWN: return {FaultKind::disconnected, fmt::format("{}: unplugged", call)};
    case EBUSY: return {FaultKind::device, fmt::format("{}: in use by another program", call)};
    case EACCES:
    case EPERM:
      return {FaultKind::device,
              fmt::format("{}: not permitted; expected the user in the device's group (video)", call)};
    case ENOSPC: return {FaultKind::device, fmt::format("{}: too little USB bandwidth left for this mode", call)};
    case ENOLINK: return {FaultKind::device, fmt::format("{}: no signal at the camera's input", call)};
    default: return {FaultKind::device, fmt::format("{}: {}", call, std::strerror(error))};
  }
}

Result<std::unique_ptr<VideoDevice>> open_video_device(const std::filesystem::path& path) {
  UniqueFd fd(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  if (!fd) {
    if (errno == ENOENT || errno == ENOTDIR || errno == ENODEV || errno == ENXIO)
      return fail(FaultKind::disconnected, "{}: no such device now", path.string());
    return fail(device_fault(errno, path.string()));
  }
  struct stat status {};
  if (::fstat(fd.value(), &status) != 0 || !S_ISCHR(status.st_mode))
    return fail(FaultKind::unsupported, "{}: expected a video device", path.string());
  return std::make_unique<SystemVideoDevice>(std::move(fd));
}

std::vector<std::filesystem::path> video_nodes(const std::filesystem::path& devices) {
  std::vector<std::pair<int, std::filesystem::path>> numbered;
  std::error_code error;
  for (std::filesystem::directory_iterator it(devices, error), end; !error && it != end; it.increment(error))
    if (const auto number = video_number(it->path())) numbered.emplace_back(*number, it->path());
  std::sort(numbered.begin(), numbered.end());
  std::vector<std::filesystem::path> nodes;
  for (auto& [number, node] : numbered) nodes.push_back(std::move(node));
  return nodes;
}

}  // namespace kasumi
