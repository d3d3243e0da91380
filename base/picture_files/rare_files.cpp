#include "base/picture_files/rare_files.hpp"

#include "base/outside/loaded_module.hpp"

namespace kasumi {

Result<const RareFiles*> rare_files() {
  static const auto kLoaded = [] {
    return loaded_module("kasumi-rare-files.so", "kasumi_rare_files", KASUMI_VERSION,
                         "films and pictures other than PNG and JPEG")
        .map([](const void* files) { return static_cast<const RareFiles*>(files); });
  }();
  return kLoaded;
}

}  // namespace kasumi
