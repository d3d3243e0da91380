#include "pipeline/kiosk/doctor/checks.hpp"

namespace kasumi {

void check_visitor(const VisitorOptions& options, Devices& devices, Findings& findings) {
  for (const auto& path : options.devices) {
    const auto device = devices.open_input(path);
    if (device)
      findings.good("visitor.device", fmt::format("{}: {}", path.string(), name_of(**device)));
    else if (device.error().kind == FaultKind::disconnected)
      findings.warn("visitor.device", device.error().message,
                    "plug it in; its stable name: ls -l /dev/input/by-id/ /dev/input/by-path/");
    else
      findings.warn("visitor.device", device.error().message,
                    "an input device of [visitor] devices? does the service have the access of docs/visitor.md?");
  }
}

}  // namespace kasumi
