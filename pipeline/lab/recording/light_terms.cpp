#include "pipeline/lab/recording/light_terms.hpp"

#include <glm/common.hpp>

#include "pipeline/site/files/photograph_file.hpp"

namespace kasumi {

Result<LightTerms> LightTerms::create(GlContext& context, const Installation& installation, const Model& model,
                                      AirRendering air, Mixing mixing) {
  air.black_object = true;
  auto in_air = Compositor::create(context, installation, model, SceneAir(installation, air), {.mixing = mixing});
  if (!in_air) return fail(in_air.error());
  air.aerial_perspective = false;
  auto black = Compositor::create(context, installation, model, SceneAir(installation, air), {.mixing = mixing});
  if (!black) return fail(black.error());
  auto target = Offscreen::create(context.info(), installation.scene.width, installation.scene.height);
  if (!target) return fail(target.error());
  return LightTerms(installation.scene.response, std::move(*in_air), std::move(*black), std::move(*target));
}

Result<Image<Rgb8>> LightTerms::drawn_by(Compositor& compositor, const Frame& frame, const SkyReport& sky) {
  if (auto drawn = compositor.draw(frame, sky, target_.target()); !drawn) return fail(drawn.error());
  return target_.read();
}

Result<> LightTerms::write(const std::filesystem::path& folder, std::size_t number, const Frame& frame,
                           const SkyReport& sky, const Image<Rgb8>& picture) {
  const auto in_air = drawn_by(black_in_air_, frame, sky);
  if (!in_air) return fail(in_air.error());
  const auto black = drawn_by(black_, frame, sky);
  if (!black) return fail(black.error());
  constexpr double kFine = 1.0 / 65535.0;
  Photograph airlight{Image<glm::vec3>(picture.width(), picture.height()), {}, kFine}, direct = airlight;
  const auto light = [&](const Rgb8& pixel) { return response_.to_light(glm::dvec3(pixel) / 255.0); };
  for (std::size_t i = 0; i < picture.elements().size(); ++i) {
    const auto whole = light(picture.elements()[i]);
    const auto scattered =
        glm::clamp(light(in_air->elements()[i]) - light(black->elements()[i]), glm::dvec3{0.0}, whole);
    airlight.encoded.elements()[i] = glm::vec3(response_.to_encoded(scattered));
    direct.encoded.elements()[i] = glm::vec3(response_.to_encoded(whole - scattered));
  }
  for (const auto& [term, pixels] : {std::pair{"airlight", &airlight}, {"direct", &direct}})
    if (auto written = write_photograph(folder / fmt::format("frame-{:06}.{}.png", number, term), *pixels); !written)
      return written;
  return {};
}

}  // namespace kasumi
