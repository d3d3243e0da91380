// A curator's model, glTF or GLB.
#include "gles/model/model.hpp"
#include "tests/fuzz/scratch.hpp"

void kasumi::try_input(std::span<const std::uint8_t> input) {
  static const Scratch scratch;
  const bool binary = input.size() >= 4 && std::equal(input.begin(), input.begin() + 4, "glTF");
  ModelLimits limits;
  limits.file_bytes = limits.texture_pixels = 1 << 20;
  const auto model = read_gltf(scratch.file(binary ? "model.glb" : "model.gltf", input), limits);
  expect_value_or_sentence(model);
  if (!model) return;
  model->bounds();
  expect_value_or_sentence(check(*model));
}
