// Checks everything a kiosk depends on; each finding says what to do.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "gles/display/display_listing.hpp"
#include "pipeline/kiosk/content/generations.hpp"
#include "pipeline/machine/devices.hpp"
#include "pipeline/machine/running_appliance.hpp"

namespace kasumi {

enum class Grade { good, warning, failure };
std::string_view name_of(Grade grade);

struct Finding {
  std::string check;  // "scene_camera.rate"; docs/operating.md lists them
  Grade grade = Grade::good;
  std::string found;                     // "24.9 frames a second of 25 asked for"
  std::string advice;                    // what to do; empty when good
  std::map<std::string, double> values;  // what was measured, units in the names
};

class Findings {
 public:
  Finding& good(std::string check, std::string found);
  Finding& warn(std::string check, std::string found, std::string advice);
  Finding& fail(std::string check, std::string found, std::string advice);
  void append(const Findings& others);
  const std::vector<Finding>& all() const { return findings_; }
  Grade worst() const;

 private:
  std::vector<Finding> findings_;
};

// Where to read the state of the kernel and systemd. Tests substitute a folder.
struct MachinePlaces {
  std::filesystem::path sys = "/sys";
  std::filesystem::path proc = "/proc";
  std::filesystem::path dev = "/dev";
  std::filesystem::path status_file = kServiceStatusFile;
  std::filesystem::path state = "/var/lib/kasumi";  // if the configuration names none
  std::function<std::vector<ListedCard>()> displays;
  // The properties of kasumi.service as `systemctl show` prints them. Errors: unsupported (no systemd).
  std::function<Result<std::string>()> unit_properties;
};
MachinePlaces this_machine();

struct DoctorRequest {
  std::filesystem::path config;              // set up by hand
  Duration watch = std::chrono::seconds(3);  // how long frames and flips are counted
  MachinePlaces places = this_machine();
  Generations generations{{}};  // the current one takes precedence over `config`
};

// BLOCKS for some seconds. While the appliance runs, its cameras and display are not opened; its status file is read
// instead.
Findings examine(const DoctorRequest& request, Devices& devices, Clock& clock);

// For a person, one line each with its advice below; for programs.
std::string doctor_text(const Findings& findings);
std::string doctor_json(const Findings& findings, Utc utc);

}  // namespace kasumi
