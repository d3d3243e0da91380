#include "pipeline/save_calibration.hpp"

#include "pipeline/picture_sink.hpp"

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
  if (written->backup) fmt::print("the file that was there is kept as {}\n", written->backup->string());
  return 0;
}

}  // namespace kasumi
