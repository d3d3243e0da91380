// Finds cards and watches for hotplugged displays through libudev.
#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <libudev.h>

#include "base/c_ptr.hpp"
#include "gles/display/kms_system.hpp"

namespace kasumi {
namespace {

using Udev = CPtr<udev, udev_unref>;
using UdevMonitor = CPtr<udev_monitor, udev_monitor_unref>;
using UdevDevice = CPtr<udev_device, udev_device_unref>;
using UdevEnumerate = CPtr<udev_enumerate, udev_enumerate_unref>;

std::string by_path_of(udev_device* device) {
  for (udev_list_entry* link = udev_device_get_devlinks_list_entry(device); link != nullptr;
       link = udev_list_entry_get_next(link)) {
    const char* name = udev_list_entry_get_name(link);
    if (name != nullptr && std::string_view(name).find("/by-path/") != std::string_view::npos) return name;
  }
  return "";
}

class UdevWatch final : public DisplayWatch {
 public:
  UdevWatch(Udev udev, UdevMonitor monitor) : udev_(std::move(udev)), monitor_(std::move(monitor)) {}

  bool take_change() override {
    bool changed = false;
    // The monitor's socket is non-blocking. Takes a bounded number of events; the next call takes the rest.
    for (int i = 0; i < 64; ++i) {
      const UdevDevice device(udev_monitor_receive_device(monitor_.get()));
      if (device == nullptr) break;
      changed = true;
    }
    return changed;
  }

 private:
  Udev udev_;
  UdevMonitor monitor_;
};

}  // namespace

std::vector<KmsCardPlace> find_cards() {
  std::vector<KmsCardPlace> places;
  const Udev udev(udev_new());
  if (udev == nullptr) return places;
  const UdevEnumerate found(udev_enumerate_new(udev.get()));
  if (found == nullptr) return places;
  udev_enumerate_add_match_subsystem(found.get(), "drm");
  udev_enumerate_add_match_sysname(found.get(), "card[0-9]*");
  udev_enumerate_scan_devices(found.get());
  std::vector<std::pair<int, KmsCardPlace>> numbered;
  for (udev_list_entry* entry = udev_enumerate_get_list_entry(found.get()); entry != nullptr;
       entry = udev_list_entry_get_next(entry)) {
    const UdevDevice device(udev_device_new_from_syspath(udev.get(), udev_list_entry_get_name(entry)));
    const char* node = device == nullptr ? nullptr : udev_device_get_devnode(device.get());
    if (node == nullptr) continue;  // a connector
    const char* number = udev_device_get_sysnum(device.get());
    numbered.emplace_back(number == nullptr ? 0 : std::atoi(number), KmsCardPlace{node, by_path_of(device.get())});
  }
  std::ranges::sort(numbered, {}, [](const auto& one) { return one.first; });
  for (auto& [number, place] : numbered) places.push_back(std::move(place));
  return places;
}

Result<std::unique_ptr<DisplayWatch>> watch_displays() {
  Udev udev(udev_new());
  if (udev == nullptr) return fail(FaultKind::unsupported, "no udev");
  UdevMonitor monitor(udev_monitor_new_from_netlink(udev.get(), "udev"));
  if (monitor == nullptr || udev_monitor_filter_add_match_subsystem_devtype(monitor.get(), "drm", nullptr) < 0 ||
      udev_monitor_enable_receiving(monitor.get()) < 0)
    return fail(FaultKind::unsupported, "udev cannot monitor displays here");
  return std::make_unique<UdevWatch>(std::move(udev), std::move(monitor));
}

}  // namespace kasumi
