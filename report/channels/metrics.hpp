// The kiosk's state as Prometheus reads it.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "report/diagnosis/diagnosis.hpp"

namespace kasumi::report {

// Of the reporter's own life.
struct OwnFigures {
  std::map<std::string, std::uint64_t> answered;  // requests by status code
  std::map<std::string, std::uint64_t> refused;   // peers by reason
  std::optional<double> resident_bytes;
  std::optional<bool> mqtt_connected;
  struct Tries {
    std::uint64_t done = 0, failed = 0;
  };
  std::optional<Tries> mails, signs_of_life;
  struct Pulls {
    std::uint64_t came = 0, unchanged = 0, failed = 0;
  };
  std::optional<Pulls> pulls;  // of content
};

// Of the disk on which the appliance keeps its state.
struct DiskFigures {
  double free_bytes = 0.0, all_bytes = 0.0;
};
std::optional<DiskFigures> disk_figures(const std::string& folder);
std::optional<double> own_resident_bytes();

// Text exposition format 0.0.4. What is not known is left out.
std::string metrics_text(const Heard& heard, const std::optional<DiskFigures>& disk, const OwnFigures& own);

}  // namespace kasumi::report
