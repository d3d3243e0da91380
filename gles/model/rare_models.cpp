#include "gles/model/rare_models.hpp"

#include "base/outside/loaded_module.hpp"

namespace kasumi {

Result<const RareModels*> rare_models() {
  static const auto kLoadedModels = [] {
    return loaded_module("kasumi-rare-models.so", "kasumi_rare_models", KASUMI_VERSION,
                         "compressed models (Draco, meshopt, WebP, KTX2)")
        .map([](const void* models) { return static_cast<const RareModels*>(models); });
  }();
  return kLoadedModels;
}

}  // namespace kasumi
