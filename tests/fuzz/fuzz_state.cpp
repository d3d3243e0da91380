// What an appliance left on its disk for its next start. The first byte chooses the file.
#include <algorithm>
#include <string>
#include <vector>

#include "pipeline/install/camera_drift/drift_reference.hpp"
#include "pipeline/kiosk/start/file_hash.hpp"
#include "pipeline/kiosk/start/remembered_layer.hpp"
#include "pipeline/kiosk/start/remembered_state.hpp"
#include "tests/fuzz/scratch.hpp"

namespace {

// For which the seed was saved.
kasumi::LandmarkWatch watch_of_one() {
  using namespace kasumi;
  Camera camera;
  camera.width = 320;
  camera.height = 180;
  camera.lens = pinhole_lens({{600.0, 600.0}, {159.5, 89.5}, {}});
  ContrastLandmark wood;
  wood.name = "wood";
  wood.distance_m = 3000.0;
  wood.surface = {20, 150, 40, 10};
  return {camera, 0.0, {wood}};
}

// With the hash that it should end its first line with: without it nothing else would be read.
std::vector<std::uint8_t> with_hash(std::span<const std::uint8_t> bytes) {
  const auto end = std::ranges::find(bytes, std::uint8_t{'\n'});
  const std::string head(bytes.begin(), end);
  const auto texels = bytes.subspan(end == bytes.end() ? bytes.size() : head.size() + 1);
  kasumi::FileHash hash;
  hash.add(head);
  hash.add(texels);
  const std::string line = head + " " + hash.hex() + "\n";
  std::vector<std::uint8_t> whole(line.begin(), line.end());
  whole.insert(whole.end(), texels.begin(), texels.end());
  return whole;
}

}  // namespace

void kasumi::try_input(std::span<const std::uint8_t> input) {
  static const Scratch scratch;
  if (input.empty()) return;
  const auto rest = input.subspan(1);
  switch (input[0]) {
    case 't': {
      scratch.file("turbidity.json", rest);
      const auto state = load_turbidity_state(scratch.folder());
      expect_value_or_sentence(state);
      if (state && !(state->sigma >= 0.0)) std::abort();
      break;
    }
    case 'l': {
      scratch.file("landmarks.json", rest);
      static const LandmarkWatch fresh = watch_of_one();
      LandmarkWatch watch = fresh;
      expect_value_or_sentence(resume(watch, scratch.folder()));
      break;
    }
    case 'b': {
      scratch.file("layer.bin", with_hash(rest));
      static const Content content;
      expect_value_or_sentence(load_layer(content, scratch.folder(), Utc{}));
      break;
    }
    default: {
      static const Installation installation;
      scratch.file("site.check.json", rest);
      expect_value_or_sentence(load_reference(scratch.folder() / "site", installation));
    }
  }
}
