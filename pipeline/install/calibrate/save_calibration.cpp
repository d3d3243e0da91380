#include "pipeline/install/calibrate/save_calibration.hpp"

#include "base/files.hpp"
#include "pipeline/site/files/picture_sink.hpp"

namespace kasumi {

Result<int> save_calibration(const std::filesystem::path& calibration, CalibrationStep step,
                             const Image<Rgb8>& drawing) {
  auto& first = step.measured.front();
  const auto name = drawing_name(calibration, step.camera, first.what);
  first.picture = name.filename().string();
  const auto written = write_calibration(calibration, step);
  if (!written) return fail(written.error());
  if (const auto drawn = write_png(name, drawing); !drawn) return fail(drawn.error());
  fmt::print("written: {}\ndrawn: {}\n", calibration.string(), name.string());
  if (written->backup) fmt::print("the previous file was kept as {}\n", written->backup->string());
  return 0;
}

Result<std::optional<std::filesystem::path>> keep_old(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::nullopt;
  const auto bytes = read_file(path);
  if (!bytes) return fail(bytes.error());
  for (int i = 1;; ++i) {
    auto name = path;
    name += fmt::format(".{}.old", i);
    if (std::filesystem::exists(name, error)) continue;
    if (auto kept = write_file(name, *bytes); !kept) return fail(kept.error());
    return name;
  }
}

std::filesystem::path beside(const std::filesystem::path& calibration, const std::string& what) {
  auto name = calibration;
  name.replace_extension();
  name += "." + what;
  return name;
}

}  // namespace kasumi
