#include "pipeline/show/stage/stage_making.hpp"

#include "gles/gl/objects.hpp"

namespace kasumi {

namespace {

// The sun high in the south.
SkyReport ordinary_noon() {
  SkyReport report;
  report.sun.source = SunSource::ephemeris;
  report.sun.direction = {0.0, -0.6, 0.8};
  report.estimate.sky = SkyCondition::clear;
  return report;
}

}  // namespace

std::shared_ptr<const PreparedStage> prepare_stage(const Content& content) {
  auto prepared = std::make_shared<PreparedStage>();
  prepared->scene = prepare_scene(content.config.installation, *content.model);
  if (content.still) prepared->still = flat_texels(*content.still, kLargestStill_px);
  return prepared;
}

std::uint64_t bytes_to_stage(const Content& content) {
  std::uint64_t bytes = 0;
  for (const auto& texture : content.model->textures) {
    bytes += texture.pixels.elements().size() * sizeof(glm::u8vec4);
    for (const auto& level : texture.smaller) bytes += level.elements().size() * sizeof(glm::u8vec4);
  }
  for (const auto* parts : {&content.model->parts, &content.model->ground})
    for (const auto& part : *parts)  // prepared, and on the GPU
      bytes += 2 * (part.vertices.size() * sizeof(GpuVertex) + part.indices.size() * sizeof(std::uint16_t));
  const auto& scene = content.config.installation.scene;
  bytes += std::uint64_t{16} * static_cast<std::uint64_t>(scene.width) * static_cast<std::uint64_t>(scene.height);
  if (content.still) bytes += 3 * content.still->elements().size() * sizeof(Rgba8);
  return bytes;
}

Result<StageMaking> StageMaking::begin(GlContext& context, ContentPtr content,
                                       std::shared_ptr<const PreparedStage> prepared, std::optional<SceneAir> air,
                                       std::optional<Rehearsal> rehearsal) {
  if (!prepared) prepared = prepare_stage(*content);
  const auto& installation = content->config.installation;
  auto scene = CompositorMaking::begin(
      context, installation, *content->model, std::shared_ptr<const CompositorInputs>(prepared, &prepared->scene),
      air ? std::move(*air) : SceneAir(installation, AirRendering{}), {.mixing = content->config.mixing});
  if (!scene) return fail(scene.error());
  if (rehearsal && rehearsal->sky.sun.source == SunSource::none) rehearsal->sky = ordinary_noon();
  return StageMaking(context, std::move(content), std::move(prepared), std::move(*scene), std::move(rehearsal));
}

Result<bool> StageMaking::step() {
  const auto part = next();
  finish_gl();  // else the pieces would add up in the driver's queue
  if (!part) return fail(part.error());
  if (auto sound = check_gl("preparing the content"); !sound) return fail(sound.error());
  part_ = *part;
  return part_ == Part::whole;
}

Result<StageMaking::Part> StageMaking::next() {
  switch (part_) {
    case Part::scene: {
      const auto whole = scene_.step();
      if (!whole) return fail(whole.error());
      return *whole ? Part::still : Part::scene;
    }
    case Part::still: return make_stage();
    case Part::layer: {
      const auto whole = stage_->compositor_.continue_layer();
      if (!whole) return fail(whole.error());
      return *whole ? Part::picture : Part::layer;
    }
    case Part::picture: return rehearse_picture();
    case Part::words: return rehearse_words();
    case Part::whole: break;
  }
  return Part::whole;
}

Result<StageMaking::Part> StageMaking::make_stage() {
  auto still = StillPicture::create(*context_, *content_, prepared_->still ? &*prepared_->still : nullptr);
  if (!still) return fail(still.error());
  prepared_.reset();
  auto stage = Stage::assemble(*context_, content_, scene_.take(), std::move(*still));
  if (!stage) return fail(stage.error());
  stage_ = std::move(*stage);
  if (!rehearsal_) return Part::whole;
  stage_->compositor_.set_view(rehearsal_->view);
  if (auto begun = stage_->compositor_.begin_layer(rehearsal_->sky, rehearsal_->layout); !begun)
    return fail(begun.error());
  return Part::layer;
}

Result<StageMaking::Part> StageMaking::rehearse_picture() {
  auto unseen = Offscreen::create(context_->info(), rehearsal_->target_width, rehearsal_->target_height);
  if (!unseen) return fail(unseen.error());
  unseen_ = std::move(*unseen);
  if (auto drawn = stage_->compositor_.rehearse(rehearsal_->layout, unseen_->target()); !drawn)
    return fail(drawn.error());
  return Part::words;
}

Result<StageMaking::Part> StageMaking::rehearse_words() {
  Rung still;
  still.still = 1.0;
  if (auto drawn = stage_->draw_over({still, {}}, SkyReport{}, unseen_->target()); !drawn) return fail(drawn.error());
  unseen_.reset();
  return Part::whole;
}

Result<> try_drawing(const ContentPtr& content, std::shared_ptr<const PreparedStage> prepared, std::string& renderer) {
  const auto context = open_headless_context();
  if (!context) return fail(context.error());
  renderer = (*context)->info().renderer;
  auto making = StageMaking::begin(**context, content, std::move(prepared), std::nullopt, Rehearsal{});
  if (!making) return fail(making.error());
  for (;;) {
    const auto whole = making->step();
    if (!whole) return fail(whole.error());
    if (*whole) return {};
  }
}

}  // namespace kasumi
