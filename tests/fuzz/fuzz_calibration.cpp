// Camera calibration: the tables of a configuration and the files it refers to. The first byte chooses which.
#include "calib/camera.hpp"
#include "tests/fuzz/scratch.hpp"

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

}  // namespace

void kasumi::try_input(std::span<const std::uint8_t> input) {
  static const Scratch scratch;
  if (input.empty()) return;
  const auto rest = input.subspan(1);
  switch (input[0]) {
    case 'j': expect_value_or_sentence(read_spectral_sensitivity(scratch.file("camera.json", rest))); break;
    case 'c': expect_value_or_sentence(read_spectral_sensitivity(scratch.file("camera.csv", rest))); break;
    case 'o': expect_value_or_sentence(read_ocamcalib(scratch.file("calib_results.txt", rest))); break;
    default: read_table({reinterpret_cast<const char*>(rest.data()), rest.size()}, scratch);
  }
}
