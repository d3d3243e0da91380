// The machine's graphics cards, on which a KMS display is opened.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "gles/display/display.hpp"
#include "gles/display/display_listing.hpp"
#include "gles/display/kms_device.hpp"
#include "gles/display/kms_scanout.hpp"

namespace kasumi {

struct KmsCardPlace {
  std::string path;     // "/dev/dri/card0"
  std::string by_path;  // "/dev/dri/by-path/pci-0000:00:02.0-card"; empty: udev gives none
};

class KmsSystem {
 public:
  virtual ~KmsSystem() = default;
  virtual std::vector<KmsCardPlace> cards() = 0;  // by number
  virtual KmsResult<std::unique_ptr<KmsDevice>> open_card(const std::string& path) = 0;
  virtual Result<std::unique_ptr<Scanout>> open_scanout(KmsDevice& device, int width, int height) = 0;
  virtual Result<std::unique_ptr<DisplayWatch>> watch() = 0;
  // Which other processes use the card, the DRM master first: "Xorg (pid 812) is master"; empty: none, or not permitted
  // to know.
  virtual std::string users_of(const std::string& path) = 0;
};
std::shared_ptr<KmsSystem> open_kms_system();

Result<std::unique_ptr<Display>> open_kms_display(const KmsDisplayOptions& options, Clock& clock,
                                                  std::shared_ptr<KmsSystem> system);

std::vector<ListedCard> list_displays(KmsSystem& system);

// The parts of the real system.
std::vector<KmsCardPlace> find_cards();                                          // udev
KmsResult<std::unique_ptr<KmsDevice>> open_drm_device(const std::string& path);  // libdrm
std::string card_users(const std::string& path, const std::filesystem::path& proc = "/proc",
                       const std::filesystem::path& debug = "/sys/kernel/debug");

}  // namespace kasumi
