// Whether `kasumi run` is using this machine's cameras and display.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace kasumi {

struct RunningAppliance {
  int pid = 0;
  std::string status;  // contents of status.json
  double age_s = 0.0;  // of the file
};

// Found by its status file and the process it names. Empty: none is running, or it never wrote one.
std::optional<RunningAppliance> find_running_appliance(const std::filesystem::path& status_file,
                                                       const std::filesystem::path& proc = "/proc");

// Where the service writes its status.
inline constexpr const char* kServiceStatusFile = "/run/kasumi/status.json";

}  // namespace kasumi
