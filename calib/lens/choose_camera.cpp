#include "calib/lens/choose_camera.hpp"

#include <algorithm>

namespace kasumi {

Result<std::size_t> choose_camera(const std::vector<ListedLens>& cameras, const std::string& wanted) {
  if (wanted.empty() && cameras.size() == 1) return 0;
  std::string listed;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const auto& [names, words] = cameras[i];
    if (std::ranges::find(names, wanted) != names.end()) return i;
    listed += fmt::format("{}{} ({})", i == 0 ? "" : ", ", names.front(), words);
  }
  if (wanted.empty())
    return fail(FaultKind::bad_input, "{} cameras: expected --import-camera with one of {}", cameras.size(), listed);
  return fail(FaultKind::bad_input, "--import-camera {}: expected one of {}", wanted, listed);
}

}  // namespace kasumi
