// A television behind HDMI, which the kernel's CEC adapter can wake and put to sleep (HDMI 1.4, supplement 1).
#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include "base/result.hpp"

namespace kasumi {

// The system calls that drive an adapter, which tests can replace.
class CecDevice {
 public:
  virtual ~CecDevice() = default;  // closes
  // ioctl(2) with a structure of <linux/cec.h>: 0, or the errno. Sending BLOCKS until the bus has taken the message, and
  // for as long as its answer may take: a few seconds.
  virtual int control(unsigned long request, void* argument) = 0;
};
// Errors: disconnected (no such file), device.
Result<std::unique_ptr<CecDevice>> open_cec_device(const std::filesystem::path& path);

enum class TelevisionPower { unknown, on, standby };
std::string_view name_of(TelevisionPower power);

// All of these BLOCK for a few seconds. Errors: device (the adapter refuses, or no device on the bus answers).
// Wakes it and makes this machine's input the one it shows.
Result<> wake_television(CecDevice& adapter);
Result<> send_television_to_sleep(CecDevice& adapter);
// What it says of itself; unknown: it does not say.
Result<TelevisionPower> ask_television(CecDevice& adapter);

}  // namespace kasumi
