#include "gles/composite/renderer_state.hpp"

#include <algorithm>

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"
#include "gles/light/airlight_grid.hpp"
#include "gles/light/appearance.hpp"

namespace kasumi {
namespace {

// The coarsest that a layer may have.
constexpr ObjectDetail kCoarsestDetail{kWidestPointSpread_px, 2, 2};

}  // namespace

bool Renderer::State::layer_in_8_bits() const {
  return options.force_rgba8 || !(info.has("GL_EXT_color_buffer_half_float") || info.has("GL_EXT_color_buffer_float"));
}

void Renderer::State::drop_layer() {
  unfinished_layer.reset();
  layer.reset();
  if (processing) processing->forget();
  composite.drop_layer();
}

void Renderer::State::look() {
  drop_layer();
  matte.reset();
  box = outline = {};
  if (!model || !projection) return;
  projection->margin_px = ObjectLayer::margin_px(kCoarsestDetail);  // whatever the detail will be
  outline = model->look_from(*projection);
  box = box_with(detail);
}

PixelBox Renderer::State::box_with(const ObjectDetail& blurred) const {
  if (outline.empty()) return {};
  return cut_to_picture(grown(outline, ObjectLayer::margin_px(blurred)), projection->view);
}

Result<> Renderer::State::find_matte() {
  if (matte || !composite.is_left_open() || !info.highp_fragments) return {};
  const int most = std::min(info.max_texture_size, 2048);
  const PixelBox largest = box_with(kCoarsestDetail);  // so that it stays while the detail changes
  MatteNodes nodes = matte_nodes(foreground->mask(), largest, most / 2, most / 2);
  if (nodes.empty()) return {};
  auto made = Matte::create(nodes, foreground->size());
  if (!made) return fail(made.error());
  matte = std::move(*made);
  if (mix) mix->take_matte(std::move(nodes));
  return {};
}

Result<> Renderer::State::follow_matte() {
  if (!matte || !composite.is_left_open()) return {};
  return matte->follow(programs, camera.newest(), *response, dither);
}

FrameInputs Renderer::State::frame() const {
  const bool open = composite.is_left_open();
  return {camera.newest(),
          *response,
          dither,
          open ? &*foreground : nullptr,
          open && matte ? &*matte : nullptr,
          passers.empty() ? nullptr : &passers,
          passers_unit,
          spare_unit};
}

Result<> Renderer::State::ready_for_frame(const DrawTarget& target) const {
  const CameraTextures& picture = camera.newest();
  if (picture.empty()) return fail(FaultKind::bad_input, "no camera picture has been uploaded to draw");
  if (target.width < 1 || target.height < 1)
    return fail(FaultKind::bad_input, "a target of {} x {} pixels: expected at least 1 x 1", target.width,
                target.height);
  return fits_view(picture.width, picture.height);
}

Result<> Renderer::State::ready_for_layer(const AirlightGrid& measured, const DrawTarget& target,
                                          const SensorNoise& noise) const {
  if (auto ready = ready_for_frame(target); !ready) return ready;
  Problems problems;
  check(measured, "measured airlight", false, problems);
  check(noise, problems);
  if (!problems.empty()) return fail(problems.fault());
  return {};
}

ProcessingSteps Renderer::State::wanted_processing() const {
  ProcessingSteps wanted{detail.sharpening, detail.jpeg_blocks ? jpeg : nullptr, {1, 1}};
  if (!info.highp_fragments) wanted.jpeg.reset();
  const PixelLayout layout = camera.newest().layout;
  if (layout == PixelLayout::i420) wanted.shared_pixels = {2, 2};
  if (layout == PixelLayout::i422) wanted.shared_pixels = {2, 1};
  return wanted;
}

Result<const CameraProcessing*> Renderer::State::process(const AirlightGrid& measured, const SensorNoise& noise) {
  const auto wanted = wanted_processing();
  if (wanted.none()) return nullptr;
  const glm::ivec2 size{camera.newest().width, camera.newest().height};
  const ObjectFootprint object{composite.changed(), composite.fully_covered(), size};
  if (object.changed.empty()) return nullptr;
  if (!processing || !processing->is_for(object, wanted)) {
    processing.reset();
    auto made = CameraProcessing::create(object, wanted, info);
    if (!made) return fail(made.error());
    processing = std::move(*made);
  }
  const TargetPlacement part(processing->part(), size.x, size.y);
  const auto whole_view = [&] { glViewport(part.box.x, part.box.y, part.box.width, part.box.height); };
  const auto draw_camera = [&](const std::vector<PixelBox>* only) {
    whole_view();
    return only ? composite.draw_camera_in(*only, programs, frame(), part)
                : composite.draw_camera_alone(programs, frame(), part);
  };
  const auto draw_composite = [&](const std::vector<PixelBox>* only) {
    whole_view();
    return composite.draw_with_coverage(only, programs, frame(), part, *layer, measured, noise);
  };
  const auto look = passers.empty() ? std::optional(ObjectLook{measured, noise}) : std::nullopt;
  if (auto done = processing->apply(look, programs, draw_camera, draw_composite); !done) return fail(done.error());
  return &*processing;
}

Result<const Image<glm::u8vec4>*> Renderer::State::mixed(const AirlightGrid* measured, const SensorNoise& noise) {
  if (!layer || !measured) return &mix->background();
  const auto covered = composite.covered_pixels(programs, frame(), *layer, *measured, noise, info);
  if (!covered) return fail(covered.error());
  return &mix->mix({composite, *covered, !passers.empty(), wanted_processing(), *measured, noise});
}

Result<> Renderer::State::show(const Image<glm::u8vec4>& picture, const DrawTarget& target) {
  const TargetPlacement shown(target, picture.width(), picture.height());
  if (shown.same_size && PictureCopy::works(info)) {
    shown.begin(target, false);
    return copy.show(picture, target, shown.box);
  }
  const auto textures = mix->upload(picture, info);
  if (!textures) return fail(textures.error());
  shown.begin(target, false);
  return composite.draw_camera_alone(programs, {*textures, *response, dither}, shown);
}

Result<> Renderer::State::picture_on_gpu() {
  if (!mixes() || camera.on_gpu()) return {};
  return camera.upload_kept(mix->planes());
}

Result<> Renderer::State::fits_view(int width, int height) const {
  if (!projection || (width == projection->view.width && height == projection->view.height)) return {};
  return fail(FaultKind::bad_input, "camera picture of {} x {} pixels: the view is of {} x {}", width, height,
              projection->view.width, projection->view.height);
}

Result<> Renderer::State::ready_for_object() const {
  Problems problems;
  if (!model) problems.add("no model has been set to draw");
  if (!projection) problems.add("no view has been set to draw from");
  if (projection && foreground && foreground->size() != glm::ivec2{projection->view.width, projection->view.height})
    problems.add("foreground mask of {} x {} pixels: the view is of {} x {}", foreground->size().x,
                 foreground->size().y, projection->view.width, projection->view.height);
  if (projection && scene_depth && scene_depth->size() != glm::ivec2{projection->view.width, projection->view.height})
    problems.add("depth map of {} x {} pixels: the view is of {} x {}", scene_depth->size().x, scene_depth->size().y,
                 projection->view.width, projection->view.height);
  if (!problems.empty()) return fail(problems.fault());
  return {};
}

bool Renderer::State::casts_shadow(const ObjectAppearance& appearance) const {
  return appearance.shadows && shadows_work && appearance.light.sun_irradiance != glm::dvec3{0.0};
}

std::optional<SunFrame> Renderer::State::new_shadow(const ObjectAppearance& appearance, bool coarse) const {
  const int texels = SunShadow::texels_for(*model, *projection, info, shadow_options) / (coarse ? 2 : 1);
  const SunFrame frame =
      make_sun_frame(model->bounds(), projection->model_to_world, appearance.light.sun_direction, texels);
  if (shadow && shadow->frame() == frame) return std::nullopt;
  return frame;
}

Result<const SunShadow*> Renderer::State::shadow_under(const ObjectAppearance& appearance) {
  if (!casts_shadow(appearance)) return nullptr;
  if (const auto frame = new_shadow(appearance)) {
    shadow.reset();
    auto drawn = SunShadow::draw(*model, *frame, shadow_options, info, programs);
    if (!drawn) return fail(drawn.error());
    shadow = std::move(*drawn);
  }
  return &*shadow;
}

void Renderer::State::bind_for_layer() const {
  glActiveTexture(GL_TEXTURE0 + kDitherUnit);
  glBindTexture(GL_TEXTURE_2D, dither.name());
  if (foreground) foreground->bind();
}

Result<> Renderer::State::begin_tiles(UnfinishedLayer& unfinished) {
  const ObjectAppearance& appearance = unfinished.appearance;
  if (auto lit = follow(appearance.light, unfinished.sky.get()); !lit) return lit;
  auto ground = GroundLight::upload(appearance, projection->model_to_world, info);
  if (!ground) return fail(ground.error());
  unfinished.ground = std::make_unique<GroundLight>(std::move(*ground));
  auto drawing =
      LayerDrawing::begin(*model, *projection, unfinished.box, appearance.horizon,
                          {layer_in_8_bits(), largest_n(appearance, sky, model->materials()),
                           appearance.aerial_perspective, appearance.haze.fog_per_m > 0.0, foreground.has_value(),
                           unfinished.detail, scene_depth ? &*scene_depth : nullptr, scene_depth_unit,
                           casts_shadow(appearance) ? &*shadow : nullptr, unfinished.ground.get()},
                          info, programs, [this, appearance](const Program& program) {
                            set_appearance(program, appearance);
                            sky.bind(program, units_for_layer().sky);
                          });
  if (!drawing) return fail(drawing.error());
  unfinished.drawing = std::move(*drawing);
  return {};
}

Result<> Renderer::State::take_layer(ObjectLayer made, const ObjectDetail& with) {
  const auto texels = made.read();
  if (!texels) return fail(texels.error());
  composite.take(made, projection->view, *texels, foreground ? &*foreground : nullptr);
  if (processing) processing->forget();
  if (auto found = find_matte(); !found) return found;
  if (mix) {
    auto stored = made.read_texels();
    if (!stored) return fail(stored.error());
    const bool open = composite.is_left_open();
    mix->take_layer({made.box(), made.unit(), std::move(*stored)}, composite, open ? &foreground->texels() : nullptr,
                    open && matte.has_value());
  }
  detail = with;
  box = made.box();
  layer = std::move(made);
  unfinished_layer.reset();
  return {};
}

Result<> Renderer::State::finish_layer(ObjectLayer drawn) {
  const ObjectDetail with = unfinished_layer->detail;
  if (auto taken = take_layer(std::move(drawn), with); !taken) return taken;
  shadow.reset();  // its maps are large, and the sun moves on
  release_compiler();
  return check_gl("cutting the picture");
}

Result<bool> Renderer::State::next_piece() {
  if (!unfinished_layer) return true;  // nothing to be seen of the object
  UnfinishedLayer& unfinished = *unfinished_layer;
  if (unfinished.shadow) {
    const auto whole = unfinished.shadow->step();
    if (!whole) return whole;
    if (!*whole) return false;
    shadow = unfinished.shadow->take();
    unfinished.shadow.reset();
    return false;
  }
  if (!unfinished.drawing) {
    if (auto begun = begin_tiles(unfinished); !begun) return fail(begun.error());
    return false;
  }
  bind_for_layer();
  const auto whole = unfinished.drawing->step();
  if (!whole || !*whole) return whole;
  if (auto finished = finish_layer(unfinished.drawing->take()); !finished) return fail(finished.error());
  return true;
}

Result<> Renderer::State::follow(const ObjectLight& light, const AtlasSquares* prepared) {
  return sky.update(light.around, reflects(), prepared);
}

}  // namespace kasumi
