#include <algorithm>

#include "base/outside/abandonable.hpp"
#include "pipeline/kiosk/doctor/checks.hpp"

namespace kasumi {

namespace {

struct SeenInput {
  std::string name, pressed;
};

// "KEY_SPACE (then_and_now)", or the number of a key that does nothing here.
std::string pressed_now(InputDevice& device, const VisitorOptions& options) {
  std::vector<std::string> keys;
  for (const int code : keys_down(device)) {
    std::string does = "nothing";
    for (std::size_t i = 0; i < kHandKeys; ++i)
      if (std::ranges::find(options.keys[i], code) != options.keys[i].end()) does = kHandKeyNames[i];
    keys.push_back(fmt::format("{} ({})", input_key_name(code), does));
  }
  return keys.empty() ? "nothing is pressed" : fmt::format("pressed: {}", fmt::join(keys, ", "));
}

}  // namespace

void check_visitor(const VisitorOptions& options, Devices& devices, Findings& findings) {
  for (const auto& path : options.devices) {
    // A thread that is left behind ends with the program (command_doctor.cpp).
    const auto seen = within<Result<SeenInput>>(kInputDeadline, [&devices, path, options]() -> Result<SeenInput> {
      const auto device = devices.open_input(path);
      if (!device) return fail(device.error());
      return SeenInput{name_of(**device), pressed_now(**device, options)};
    });
    if (!seen)
      findings.warn(
          "visitor.device",
          fmt::format("{}: hung: its driver has not answered for {:.0f} s", path.string(), to_seconds(kInputDeadline)),
          "unplug it and plug it in again; the picture goes on without it");
    else if (*seen)
      findings.good("visitor.device", fmt::format("{}: {}; {}", path.string(), (*seen)->name, (*seen)->pressed));
    else if (seen->error().kind == FaultKind::disconnected)
      findings.warn("visitor.device", seen->error().message,
                    "plug it in; its stable name: ls -l /dev/input/by-id/ /dev/input/by-path/");
    else
      findings.warn("visitor.device", seen->error().message,
                    "an input device of [visitor] devices? does the service have the access of docs/visitor.md?");
  }
}

}  // namespace kasumi
