// The system calls that read an input device of the kernel: an interface that tests can replace.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <linux/input.h>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace kasumi {

class InputDevice {
 public:
  virtual ~InputDevice() = default;  // closes
  // read(2), which never blocks: how many events were read, or, negative, the errno.
  virtual int read(std::span<input_event> events) = 0;
  // poll(2): BLOCKS until there is something to read, for at most `longest`.
  virtual void wait(Duration longest) = 0;
  // ioctl(2): 0 or more, or, negative, the errno.
  virtual int control(unsigned long request, void* argument) = 0;
};

// Read-only. Errors: disconnected (no such file), unsupported (not an input device), device (any other failure).
Result<std::unique_ptr<InputDevice>> open_input_device(const std::filesystem::path& path);

// As the device calls itself; empty: it does not say.
std::string name_of(InputDevice& device);
// Codes of the keys that are down.
std::vector<int> keys_down(InputDevice& device);

}  // namespace kasumi
