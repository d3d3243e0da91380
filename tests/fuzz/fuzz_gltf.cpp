// A curator's model, glTF or GLB.
#include "gles/model/model.hpp"
#include "tests/fuzz/scratch.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kasumi;
  static const Scratch scratch;
  const bool binary = size >= 4 && std::equal(data, data + 4, "glTF");
  ModelLimits limits;
  limits.file_bytes = 1 << 20;
  const auto model = read_gltf(scratch.file(binary ? "model.glb" : "model.gltf", {data, size}), limits);
  expect_value_or_sentence(model);
  if (!model) return 0;
  model->bounds();
  expect_value_or_sentence(check(*model));
  return 0;
}
