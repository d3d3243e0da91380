// Whether `kasumi run` has this machine's cameras and display now.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace kasumi {

struct RunningAppliance {
  int pid = 0;
  std::string status;  // status.json as it was read
  double age_s = 0.0;  // of the file
};

// By its status file and the process it names. Empty: none is running (or it never wrote one).
std::optional<RunningAppliance> find_running_appliance(const std::filesystem::path& status_file,
                                                       const std::filesystem::path& proc = "/proc");

// Where the service writes it.
inline constexpr const char* kServiceStatusFile = "/run/kasumi/status.json";

}  // namespace kasumi
