#include "gles/packed/module.hpp"

#include <exception>

namespace kasumi {

namespace {

// Libraries throw where memory is short, or at what they did not expect.
template <class Read>
auto guarded(Read&& read) -> decltype(read()) {
  try {
    return read();
  } catch (const std::exception& thrown) {
    return fail(FaultKind::bad_input, "cannot be decoded ({})", thrown.what());
  }
}

class PackedModels final : public RareModels {
 public:
  Result<DracoMesh> draco_mesh(std::span<const std::uint8_t> stream, std::span<DracoAttribute> attributes,
                               const DracoLimits& limits) const override {
    return guarded([&] { return read_draco(stream, attributes, limits); });
  }
  Result<std::vector<std::uint8_t>> meshopt_view(std::span<const std::uint8_t> stream, const MeshoptBuffer& view,
                                                 std::size_t most) const override {
    return guarded([&] { return read_meshopt(stream, view, most); });
  }
  Result<Image<glm::u8vec4>> webp_picture(std::span<const std::uint8_t> file, int width, int height) const override {
    return guarded([&] { return read_webp(file, width, height); });
  }
  Result<Image<glm::u8vec4>> ktx2_picture(std::span<const std::uint8_t> file, int width, int height) const override {
    return guarded([&] { return read_ktx2(file, width, height); });
  }
  std::vector<std::uint32_t> simplified(std::span<const glm::vec3> positions, std::span<const std::uint32_t> indices,
                                        float error) const override {
    return simplified_mesh(positions, indices, error);
  }
};

}  // namespace

}  // namespace kasumi

extern "C" {
extern const char kasumi_rare_models_version[];
const char kasumi_rare_models_version[] = KASUMI_VERSION;

const kasumi::RareModels* kasumi_rare_models() {
  static const kasumi::PackedModels kModels;
  return &kModels;
}
}
