#include "tests/estimator/air/every_camera.hpp"

#include <algorithm>
#include <filesystem>

#include <gtest/gtest.h>

#include "tests/places.hpp"

namespace kasumi {

std::vector<SpectralSensitivity> every_camera() {
  std::vector<SpectralSensitivity> cameras{generic_sensitivity()};
  const std::filesystem::path folder = shared_data_folder() / "spectral";
  if (!std::filesystem::exists(folder)) return cameras;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const auto extension = entry.path().extension();
    if (extension == ".json" || extension == ".csv") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    auto sensitivity = read_spectral_sensitivity(file);
    EXPECT_TRUE(sensitivity) << (sensitivity ? "" : sensitivity.error().message);
    if (sensitivity) cameras.push_back(std::move(*sensitivity));
  }
  return cameras;
}

}  // namespace kasumi
