#include "gles/display/kms_system.hpp"

namespace kasumi {
namespace {

class MachineSystem final : public KmsSystem {
 public:
  std::vector<KmsCardPlace> cards() override { return find_cards(); }
  KmsResult<std::unique_ptr<KmsDevice>> open_card(const std::string& path) override { return open_drm_device(path); }
  Result<std::unique_ptr<Scanout>> open_scanout(KmsDevice& device, int width, int height) override {
    return open_gbm_scanout(device, width, height);
  }
  Result<std::unique_ptr<DisplayWatch>> watch() override { return watch_displays(); }
  std::string users_of(const std::string& path) override { return card_users(path); }
};

}  // namespace

std::shared_ptr<KmsSystem> open_kms_system() {
  return std::make_shared<MachineSystem>();
}

}  // namespace kasumi
