#include "pipeline/machine/buttons/input_device.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "base/unique_fd.hpp"

namespace kasumi {

namespace {

class SystemInputDevice final : public InputDevice {
 public:
  explicit SystemInputDevice(UniqueFd fd) : fd_(std::move(fd)) {}
  int read(std::span<input_event> events) override {
    const auto got = ::read(fd_.value(), events.data(), events.size_bytes());
    return got < 0 ? -errno : static_cast<int>(static_cast<std::size_t>(got) / sizeof(input_event));
  }
  void wait(Duration longest) override {
    pollfd readable{fd_.value(), POLLIN, 0};
    ::poll(&readable, 1, static_cast<int>(std::chrono::ceil<std::chrono::milliseconds>(longest).count()));
  }
  int control(unsigned long request, void* argument) override {
    const int done = ::ioctl(fd_.value(), request, argument);
    return done < 0 ? -errno : done;
  }

 private:
  UniqueFd fd_;
};

}  // namespace

Result<std::unique_ptr<InputDevice>> open_input_device(const std::filesystem::path& path) {
  UniqueFd fd(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY));
  if (!fd) {
    if (errno == ENOENT || errno == ENOTDIR || errno == ENODEV || errno == ENXIO)
      return fail(FaultKind::disconnected, "{}: no such device now", path.string());
    if (errno == EACCES || errno == EPERM)
      return fail(FaultKind::device,
                  "{}: not permitted; expected the user in the group input, and DeviceAllow=char-input r",
                  path.string());
    return fail(FaultKind::device, "{}: {}", path.string(), std::strerror(errno));
  }
  struct stat status {};
  int version = 0;
  if (::fstat(fd.value(), &status) != 0 || !S_ISCHR(status.st_mode) || ::ioctl(fd.value(), EVIOCGVERSION, &version) < 0)
    return fail(FaultKind::unsupported, "{}: expected an input device", path.string());
  return std::make_unique<SystemInputDevice>(std::move(fd));
}

std::string name_of(InputDevice& device) {
  std::array<char, 128> name{};
  if (device.control(EVIOCGNAME(name.size() - 1), name.data()) < 0) return {};
  std::string text = name.data();  // by the device itself: it may hold anything
  std::ranges::replace_if(
      text, [](char c) { return c < ' ' || c > '~'; }, '?');
  return text;
}

std::vector<int> keys_down(InputDevice& device) {
  std::array<std::uint8_t, KEY_MAX / 8 + 1> bits{};
  std::vector<int> codes;
  if (device.control(EVIOCGKEY(bits.size()), bits.data()) < 0) return codes;
  for (int code = 0; code <= KEY_MAX; ++code)
    if ((bits[static_cast<std::size_t>(code) / 8] >> (code % 8)) & 1) codes.push_back(code);
  return codes;
}

}  // namespace kasumi
