#include "base/outside/this_boot.hpp"

#include <ctime>

#include "base/files.hpp"

namespace kasumi {

std::string boot_id() {
  const auto text = read_text_file("/proc/sys/kernel/random/boot_id").value_or("");
  return text.substr(0, text.find('\n'));
}

double since_boot_s() {
  timespec now{};
  ::clock_gettime(CLOCK_BOOTTIME, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace kasumi
