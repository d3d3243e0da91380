#include "pipeline/machine/rest_period.hpp"

#include <utility>

namespace kasumi {

namespace {

SourceOpener rested(SourceOpener opener, const RestPeriod& rest, Clock& clock) {
  const auto until = std::make_shared<Instant>(clock.now() + rest.lasts);
  auto open = [until, open = opener.open, why = rest.why, &clock]() -> Result<std::unique_ptr<FrameSource>> {
    if (clock.now() < *until) return fail(FaultKind::device, "{}", why);
    return open();
  };
  opener.open = std::move(open);
  if (!opener.present) return opener;
  auto present = [until, present = opener.present] {
    const bool there = present();
    if (!there) *until = Instant::min();
    return there;
  };
  opener.present = std::move(present);
  return opener;
}

class RestingDevices final : public Devices {
 public:
  RestingDevices(Devices& devices, RestPeriod scene, RestPeriod sky, Clock& clock)
      : devices_(devices), scene_(std::move(scene)), sky_(std::move(sky)), clock_(clock) {}

  CameraOpening camera(CameraRole role, const CameraOptions& options) override {
    auto opening = devices_.camera(role, options);
    const auto rest = std::exchange(role == CameraRole::sky ? sky_ : scene_, {});
    if (rest.lasts > Duration::zero()) opening.opener = rested(std::move(opening.opener), rest, clock_);
    return opening;
  }
  Result<std::unique_ptr<Display>> open_display(const DisplayOptions& options) override {
    return devices_.open_display(options);
  }
  std::unique_ptr<DisplayWatch> watch_displays() override { return devices_.watch_displays(); }
  Result<std::unique_ptr<CecDevice>> open_television(const std::filesystem::path& adapter) override {
    return devices_.open_television(adapter);
  }
  Result<std::unique_ptr<InputDevice>> open_input(const std::filesystem::path& device) override {
    return devices_.open_input(device);
  }
  void serve(std::shared_ptr<InputLink> link) override { devices_.serve(std::move(link)); }

 private:
  Devices& devices_;
  RestPeriod scene_, sky_;
  Clock& clock_;
};

}  // namespace

std::unique_ptr<Devices> resting(Devices& devices, const RestPeriod& scene, const RestPeriod& sky, Clock& clock) {
  return std::make_unique<RestingDevices>(devices, scene, sky, clock);
}

}  // namespace kasumi
