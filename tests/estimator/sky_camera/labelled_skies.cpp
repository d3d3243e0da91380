#include "tests/estimator/sky_camera/labelled_skies.hpp"

#include <algorithm>
#include <filesystem>

#include "tests/csv.hpp"
#include "tests/opencv_pictures.hpp"
#include "tests/places.hpp"

namespace kasumi::test {
namespace {

double number(const std::string& text, double otherwise) {
  return text.empty() ? otherwise : std::stod(text);
}

LabelledSky read(const std::filesystem::path& folder, CsvRow& row) {
  LabelledSky sky;
  sky.file = row["file"];
  sky.id = row["id"];
  sky.name = row["camera"];
  sky.sky = row["sky"];
  if (!row["cloud"].empty()) sky.cloud = std::stod(row["cloud"]);
  sky.pixels = read_rgb(folder / sky.file);
  // The horizon's circle where that and the image's edge are labelled.
  const bool second = number(row["r2"], 1e9) < number(row["r"], 0.0);
  const std::string which = second ? "2" : "";
  const double radius = number(row["r" + which], 0.0);
  sky.camera.width = sky.pixels.width();
  sky.camera.height = sky.pixels.height();
  sky.camera.lens = equidistant_lens({number(row["cx" + which], 0.0), number(row["cy" + which], 0.0)},
                                     radius / (0.5 * kPi), {0.5 * kPi});
  sky.camera.to_world = camera_to_world(from_degrees(180), from_degrees(90), {0});
  for (const char* which_circle : {"", "2"}) {
    const std::string of = which_circle;
    if (!row["r" + of].empty())
      sky.circles.push_back({{number(row["cx" + of], 0.0), number(row["cy" + of], 0.0)}, number(row["r" + of], 0.0)});
  }
  sky.circle_tolerance = number(row["tol"], 2.0) / 100.0;
  sky.tolerance_px = std::max(2.0 / 90.0 * radius, number(row["sun_tol"], 0.0));
  const std::string& sun = row["sun"];
  sky.sun_scored = sun == "disc" || sun == "blob" || sun == "none" || sun == "hidden";
  if (!row["sun_x"].empty()) sky.sun_px = {number(row["sun_x"], 0.0), number(row["sun_y"], 0.0)};
  return sky;
}

}  // namespace

std::vector<LabelledSky> labelled_skies() {
  const auto folder = shared_data_folder() / "sky" / "real";
  std::vector<LabelledSky> skies;
  for (CsvRow& row : read_csv(folder / "labels.csv"))
    if (row["circle"] == "yes" && std::filesystem::exists(folder / row["file"])) skies.push_back(read(folder, row));
  return skies;
}

}  // namespace kasumi::test
