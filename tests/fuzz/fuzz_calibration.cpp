// Camera calibration: the tables of a configuration and the files it refers to. The first byte chooses which.
#include "calib/camera.hpp"
#include "calib/distances/distance_map.hpp"
#include "calib/lens/import_lens.hpp"
#include "tests/fuzz/scratch.hpp"
#include "tests/fuzz/small_picture.hpp"

namespace {

void read_table(std::string_view text, const kasumi::Scratch& scratch) {
  using namespace kasumi;
  const auto root = ConfigTable::parse(text, scratch.folder() / "calibration.toml");
  expect_value_or_sentence(root);
  if (!root) return;
  read_site(root->table("site"));
  const auto camera = read_camera(root->table("sky"), "sky");
  const bool sound = root->finish().has_value();
  if (!sound || !camera.lens) return;
  // A camera that was accepted must be usable.
  for (const glm::dvec2 pixel : {glm::dvec2{0.0, 0.0}, glm::dvec2{camera.width - 1.0, camera.height - 1.0}})
    if (const auto direction = camera.lens->unproject(pixel)) camera.lens->project(*direction);
  camera.vignetting.at({0.0, 0.0});
}

void read_foreign_lens(const std::filesystem::path& file) {
  using namespace kasumi;
  const auto imported = import_lens(file, {"opencv_fisheye", {}});
  expect_value_or_sentence(imported);
  if (!imported) return;
  const auto lens = make_lens(imported->lens);
  for (const double x : {0.0, 0.5, 2.0})
    if (const auto pixel = lens->project({x, 0.1, 1.0})) lens->unproject(*pixel);
}

}  // namespace

void kasumi::try_input(std::span<const std::uint8_t> input) {
  static const Scratch scratch;
  if (input.empty()) return;
  const auto rest = input.subspan(1);
  switch (input[0]) {
    case 'j': expect_value_or_sentence(read_spectral_sensitivity(scratch.file("camera.json", rest))); break;
    case 'c': expect_value_or_sentence(read_spectral_sensitivity(scratch.file("camera.csv", rest))); break;
    case 'o': expect_value_or_sentence(read_ocamcalib(scratch.file("calib_results.txt", rest))); break;
    case 'l': read_foreign_lens(scratch.file("lens", rest)); break;
    case 'd':
      if (!is_large_picture(rest)) expect_value_or_sentence(read_distances(scratch.file("depth", rest), {}, 64, 48));
      break;
    default: read_table({reinterpret_cast<const char*>(rest.data()), rest.size()}, scratch);
  }
}
