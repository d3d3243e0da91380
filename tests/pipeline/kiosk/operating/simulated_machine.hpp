// A machine simulated by files, and what a check of the doctor's finds on it.
#pragma once

#include <nlohmann/json.hpp>

#include "pipeline/kiosk/doctor/checks.hpp"
#include "tests/pipeline/kiosk/operating/kiosk.hpp"

namespace kasumi {

// A folder that replaces /sys, /proc, /dev and /run.
class Machine {
 public:
  explicit Machine(const std::string& name) : folder_(operating_folder("machine-" + name)) {
    places.sys = folder_ / "sys";
    places.proc = folder_ / "proc";
    places.dev = folder_ / "dev";
    places.status_file = folder_ / "run/kasumi/status.json";
    places.state = folder_ / "state";
    places.displays = [] { return std::vector<ListedCard>(); };
    places.unit_properties = [this]() -> Result<std::string> { return unit; };
    std::filesystem::create_directories(places.state);
  }
  void write(const std::string& path, const std::string& text) {
    std::filesystem::create_directories((folder_ / path).parent_path());
    std::ofstream(folder_ / path) << text;
  }
  void link(const std::string& path, const std::string& to) {
    std::filesystem::create_directories((folder_ / path).parent_path());
    std::filesystem::create_directories((folder_ / to).parent_path());
    std::filesystem::create_symlink(folder_ / to, folder_ / path);
  }
  // As `kasumi run` would write it.
  void run_appliance(const nlohmann::json& status) {
    write("run/kasumi/status.json", status.dump());
    write("proc/4711/comm", "kasumi\n");
  }

  MachinePlaces places;
  std::string unit =
      "LoadState=loaded\nActiveState=active\nUnitFileState=enabled\nNRestarts=0\nWatchdogUSec=20s\nResult=success\n";

 private:
  std::filesystem::path folder_;
};

inline Finding found(const Findings& findings, const std::string& check) {
  for (const auto& finding : findings.all())
    if (finding.check == check) return finding;
  ADD_FAILURE() << "no finding " << check << " in\n" << doctor_text(findings);
  return {};
}
inline bool has(const Findings& findings, const std::string& check) {
  return std::any_of(findings.all().begin(), findings.all().end(), [&](const auto& f) { return f.check == check; });
}
// What a check finds of these inputs.
template <class Check, class... Inputs>
Finding judged_by(Check check, const char* name, const Inputs&... inputs) {
  Findings findings;
  check(inputs..., findings);
  return found(findings, name);
}

}  // namespace kasumi
