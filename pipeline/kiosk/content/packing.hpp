// From a configuration and all that it names to a bundle, on the desk of whoever makes it.
#pragma once

#include <functional>
#include <optional>

#include "pipeline/kiosk/content/bundle.hpp"
#include "pipeline/kiosk/content/model_reduction.hpp"

namespace kasumi {

struct PackRequest {
  std::filesystem::path config;
  std::filesystem::path out;
  std::string name;
  Utc created{};
  std::optional<std::filesystem::path> secret_key;  // of minisign's
  std::function<Result<std::string>()> password;    // asked for if the key is encrypted
  std::vector<std::string> for_kiosks{};            // empty: for all
  bool keep_all = false;                            // models are packed as they are, however large
  double most_loss = kMostModelLoss;                // of reduced models, of 255 (model_reduction.hpp)
};

struct Packed {
  std::string id;
  Manifest manifest;
  std::vector<std::string>
      remarks;  // what was reduced; files of the machine's own that are named but not packed; what was not tried; what of models is left out
  std::string renderer;  // what drew it; empty: no GL here
};

// Reads everything as the appliance would, reduces models that are too large for it, and draws it once unseen, so that a
// mistake is named before it leaves the desk; then packs and, with a key, signs it. Errors (bad_input): all problems at once; io.
Result<Packed> pack(const PackRequest& request);

}  // namespace kasumi
