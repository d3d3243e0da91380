#include "gles/composite/renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <glm/gtc/packing.hpp>

#include "gles/composite/renderer_state.hpp"
#include "gles/gl/gl.hpp"
#include "gles/gl/patterns.hpp"
#include "gles/gl/texture_units.hpp"
#include "gles/light/airlight_grid.hpp"
#include "gles/light/appearance.hpp"

namespace kasumi {
namespace {

void check(const ObjectDetail& detail, Problems& problems) {
  if (!(detail.point_spread_px >= 0.0 && detail.point_spread_px <= kWidestPointSpread_px))
    problems.add("detail: a point spread of {} px: expected 0 .. {}", detail.point_spread_px, kWidestPointSpread_px);
  const auto shared = [](int pixels) { return pixels == 1 || pixels == 2; };
  if (!shared(detail.chroma_columns) || !shared(detail.chroma_rows))
    problems.add("detail: a colour for {} x {} pixels: expected 1 or 2 each way", detail.chroma_columns,
                 detail.chroma_rows);
  if (!(detail.sharpening >= 0.0 && detail.sharpening <= kStrongestSharpening))
    problems.add("detail: sharpening by {}: expected 0 .. {}", detail.sharpening, kStrongestSharpening);
}

// Half floats whose exponent has all five bits are infinite or no numbers.
bool is_finite(const glm::u16vec4& halves) {
  constexpr std::uint16_t kExponent = 0x7C00;  // IEEE 754
  for (int c = 0; c < 4; ++c)
    if ((halves[c] & kExponent) == kExponent) return false;
  return true;
}

// Calls it until it says that it is done.
template <class Step>
Result<> until_done(Step step) {
  for (;;) {
    const auto done = step();
    if (!done) return fail(done.error());
    if (*done) return {};
  }
}

// Draws `right` from this column of the target on, and `left` before it.
template <class Left, class Right>
Result<> right_of(int column, const DrawTarget& target, Right right, Left left) {
  if (column <= 0) return right();
  glEnable(GL_SCISSOR_TEST);
  glScissor(column, 0, target.width - column, target.height);
  auto drawn = right();
  glScissor(0, 0, column, target.height);
  if (drawn) drawn = left();
  glDisable(GL_SCISSOR_TEST);
  return drawn;
}

}  // namespace

Renderer::Renderer(std::unique_ptr<State> state) : state_(std::move(state)) {}
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

Result<Renderer> Renderer::create(GlContext& context, const RendererOptions& options) {
  constexpr GLint kUniforms = 64;  // what our programs may take; GLES 2 promises 16
  GLint uniforms = 0, textures = 0;
  glGetIntegerv(GL_MAX_FRAGMENT_UNIFORM_VECTORS, &uniforms);
  glGetIntegerv(GL_MAX_TEXTURE_IMAGE_UNITS, &textures);
  if (uniforms < kUniforms || textures < kPromisedUnits)
    return fail(FaultKind::unsupported, "{}: {} fragment uniform vectors and {} texture units: need {} and {}",
                context.info().renderer, uniforms, textures, kUniforms, kPromisedUnits);
  auto state = std::make_unique<State>(context.info(), options);
  state->dither = make_dither_pattern();
  state->units_in_one_pass = units_beside_camera(textures);
  if (textures > kMatteUnit && !options.force_promised_units) state->spare_unit = kMatteUnit;
  if (textures > kPassersUnit && !options.force_promised_units) state->passers_unit = kPassersUnit;
  const bool compares_depths = textures > kSceneDepthUnit && state->info.highp_fragments;
  state->scene_depth_unit = compares_depths ? static_cast<int>(kSceneDepthUnit) : -1;
  GLint varyings = 0;
  glGetIntegerv(GL_MAX_VARYING_VECTORS, &varyings);
  state->many_varyings = varyings > 8;
  state->shadow_options =
      SunShadow::options_for(state->info, {options.force_packed_shadows, !options.force_smooth_shadows});
  state->shadows_work = state->info.highp_fragments && textures > kShadowUnit;
  if (!state->shadows_work) state->notes.emplace_back("no shadows: too few texture units or too little precision");
  auto response = ResponseOnGpu::create({});
  if (!response) return fail(response.error());
  state->response = std::move(*response);
  if (!state->info.highp_fragments)
    state->notes.emplace_back(
        "fragment shaders compute in 16 bits: glints of mapped materials are up to 12 of 255 off, dithering is coarse");
  if (state->layer_in_8_bits()) state->notes.emplace_back("the object's layer is kept in 8 bits (square roots)");
  const bool software = options.mixing == Mixing::automatic && state->info.software;
  if (software || options.mixing == Mixing::processor) state->mix.emplace();
  if (auto made = check_gl("creating the renderer"); !made) return fail(made.error());
  return Renderer(std::move(state));
}

Result<> Renderer::set_model(const Model& model) {
  if (auto begun = begin_model(model); !begun) return begun;
  return until_done([this] { return continue_model(); });
}

Result<> Renderer::begin_model(const Model& model, std::shared_ptr<const TriangleChunks> chunks) {
  State& s = *state_;
  auto upload = ModelUpload::begin(model, std::move(chunks), s.info, s.options.force_encoded_textures, s.notes);
  if (!upload) return fail(upload.error());
  s.unfinished_model = std::move(*upload);
  return {};
}

Result<bool> Renderer::continue_model() {
  State& s = *state_;
  const auto whole = s.unfinished_model->step();
  if (!whole || !*whole) return whole;
  s.model = s.unfinished_model->take();
  s.unfinished_model.reset();
  if (!std::ranges::all_of(s.model->materials(), [&](const auto& m) { return holds(s.units_in_one_pass, m); }))
    s.notes.emplace_back("a moving view leaves out some pictures of the model: too few texture units");
  s.shadow.reset();
  s.look();
  return true;
}

Result<> Renderer::set_view(const SceneView& view, const glm::dmat4& model_to_world) {
  auto projection = make_projection(view, model_to_world);
  if (!projection) return fail(projection.error());
  state_->projection = *projection;
  state_->look();
  return {};
}

Result<> Renderer::set_foreground(const Image<std::uint8_t>& mask, double point_spread_px) {
  if (!(point_spread_px >= 0.0 && point_spread_px <= kWidestPointSpread_px))
    return fail(FaultKind::bad_input, "foreground: a point spread of {} px: expected 0 .. {}", point_spread_px,
                kWidestPointSpread_px);
  State& s = *state_;
  s.drop_layer();
  s.foreground.reset();
  s.matte.reset();
  if (mask.empty()) return {};
  auto made = Foreground::upload(mask, point_spread_px, s.info);
  if (!made) return fail(made.error());
  s.foreground = std::move(*made);
  return {};
}

Result<> Renderer::set_scene_depth(const Image<float>& depth_m) {
  State& s = *state_;
  s.drop_layer();
  s.scene_depth.reset();
  if (depth_m.empty()) return {};
  if (s.scene_depth_unit < 0) {
    s.notes.push_back(fmt::format("the depth map is not used: {} has too few texture units or too little precision",
                                  s.info.renderer));
    return {};
  }
  auto made = SceneDepth::upload(depth_m, s.info);
  if (!made) return fail(made.error());
  s.scene_depth = std::move(*made);
  return {};
}

Result<> Renderer::set_detail(const ObjectDetail& detail) {
  Problems problems;
  check(detail, problems);
  if (!problems.empty()) return fail(problems.fault());
  State& s = *state_;
  if (detail == s.detail) return {};
  s.detail = detail;
  s.drop_layer();
  s.box = s.box_with(detail);
  return {};
}

Result<> Renderer::set_response(const ResponseCurve& response) {
  auto made = ResponseOnGpu::create(response);
  if (!made) return fail(made.error());
  state_->response = std::move(*made);
  if (state_->mix) state_->mix->take_response(response);
  state_->composite.change_response();
  if (state_->processing) state_->processing->forget();
  return {};
}

std::size_t Renderer::model_bytes() const {
  return state_->model ? state_->model->bytes() : 0;
}

PixelBox Renderer::object_box() const {
  return state_->box;
}

PixelBox Renderer::object_box(const ObjectDetail& detail) const {
  return state_->box_with(detail);
}

bool Renderer::reflects() const {
  return state_->model && state_->reflects();
}

Result<> Renderer::redraw_layer(const ObjectAppearance& appearance) {
  if (auto begun = begin_layer(appearance); !begun) return begun;
  return until_done([this] { return continue_layer(); });
}

Result<> Renderer::begin_layer(const ObjectAppearance& appearance, const WithLayer& with) {
  State& s = *state_;
  if (auto ready = s.ready_for_object(); !ready) return ready;
  Problems problems;
  check(appearance, problems);
  const ObjectDetail detail = with.detail.value_or(s.detail);
  check(detail, problems);
  if (!problems.empty()) return fail(problems.fault());
  s.unfinished_layer.reset();
  const PixelBox box = s.box_with(detail);
  if (box.empty()) {
    s.drop_layer();
    s.detail = detail;
    s.box = {};
    return {};
  }

  State::UnfinishedLayer unfinished{appearance, with.sky, detail, box, std::nullopt, nullptr, std::nullopt};
  const bool shadow = s.casts_shadow(appearance);
  s.coarse_shadow = shadow && with.soon && s.info.software;
  const auto frame = shadow ? s.new_shadow(appearance, s.coarse_shadow) : std::nullopt;
  if (frame) {
    s.shadow.reset();
    auto drawing = SunShadowDrawing::begin(*s.model, *frame, s.shadow_options, s.info, s.programs);
    if (!drawing) return fail(drawing.error());
    unfinished.shadow = std::move(*drawing);
  }
  s.unfinished_layer = std::move(unfinished);
  return {};
}

Result<bool> Renderer::continue_layer(const std::function<bool()>& time_is_left) {
  for (;;) {
    const auto whole = state_->next_piece();
    // Queued GPU work delays the picture too, and software GL keeps the memory of all that ever waited for it.
    if (time_is_left || state_->info.software) glFinish();
    if (!whole || *whole || !time_is_left) return whole;
    if (!time_is_left()) return false;
  }
}

bool Renderer::has_coarse_shadow() const {
  return state_->coarse_shadow;
}

Result<Image<glm::vec4>> Renderer::read_layer() {
  const State& s = *state_;
  if (!s.layer) return Image<glm::vec4>();
  const PixelBox& box = s.layer->box();
  auto texels = s.layer->read();
  if (texels && s.foreground)
    for (int y = 0; y < texels->height(); ++y)
      for (int x = 0; x < texels->width(); ++x)
        texels->at(x, y) *= static_cast<float>(s.foreground->mask().at(box.left + x, box.top + y)) / 255.0f;
  return texels;
}

std::optional<KeptLayer> Renderer::layer_to_keep() const {
  const State& s = *state_;
  if (!s.layer || !s.mix || s.layer_in_8_bits()) return std::nullopt;
  const auto texels = s.layer->read_texels();
  if (!texels) return std::nullopt;
  KeptLayer kept{s.box, s.detail, Image<glm::u16vec4>(texels->width(), texels->height())};
  std::ranges::transform(texels->elements(), kept.halves.elements().begin(),
                         [](const glm::vec4& texel) { return glm::packHalf(texel); });
  return kept;
}

Result<> Renderer::restore_layer(const KeptLayer& kept) {
  State& s = *state_;
  if (auto ready = s.ready_for_object(); !ready) return ready;
  Problems problems;
  check(kept.detail, problems);
  if (!problems.empty()) return fail(problems.fault());
  const PixelBox box = s.box_with(kept.detail);
  const glm::ivec2 size{box.right - box.left, box.bottom - box.top};
  if (s.layer_in_8_bits() || box.empty() || box != kept.box || kept.halves.width() != size.x ||
      kept.halves.height() != size.y)
    return fail(
        FaultKind::bad_input, "a layer of {} x {} pixels at ({}, {}): the object's box is of {} x {} at ({}, {})",
        kept.halves.width(), kept.halves.height(), kept.box.left, kept.box.top, size.x, size.y, box.left, box.top);
  if (!std::ranges::all_of(kept.halves.elements(), is_finite))
    return fail(FaultKind::bad_input, "a layer with values that are no numbers");
  auto layer = ObjectLayer::restore(box, kept.halves, s.info);
  if (!layer) return fail(layer.error());
  return s.take_layer(std::move(*layer), kept.detail);
}

Result<> Renderer::upload(const PictureView& frame, std::shared_ptr<const JpegSteps> jpeg) {
  if (auto fits = state_->fits_view(frame.width, frame.height); !fits) return fits;
  State& s = *state_;
  if (!s.mix) {
    s.jpeg = std::move(jpeg);
    return s.camera.upload(frame);
  }
  if (auto taken = s.mix->take_picture(frame); !taken) return taken;
  s.jpeg = std::move(jpeg);
  s.camera.keep(frame);
  return {};
}

Result<> Renderer::import_frame(const ExternalPicture& frame) {
  State& s = *state_;
  if (auto fits = s.fits_view(frame.width, frame.height); !fits) return fits;
  auto imported = s.camera.import_frame(frame, s.notes);
  if (!imported) return imported;
  s.jpeg.reset();
  if (s.mix) s.mix->drop_picture();
  return imported;
}

void Renderer::drop_camera_buffers() {
  state_->camera.drop_buffers();
}

FrameCounts Renderer::frames() const {
  return state_->camera.frames();
}

Result<> Renderer::draw_background(const DrawTarget& target) {
  State& s = *state_;
  if (auto ready = s.ready_for_frame(target); !ready) return ready;
  if (s.mixes()) return s.show(s.mix->background(), target);
  const TargetPlacement shown(target, s.camera.newest().width, s.camera.newest().height);
  shown.begin(target, false);
  return s.composite.draw_camera_alone(s.programs, s.frame(), shown);
}

Result<> Renderer::draw(const AirlightGrid& measured, const DrawTarget& target, const SensorNoise& noise) {
  State& s = *state_;
  const int bare = static_cast<int>(std::lround(s.bare * target.width));
  if (!s.layer || bare >= target.width) return draw_background(target);
  if (auto ready = s.ready_for_layer(measured, target, noise); !ready) return ready;
  if (s.mixes()) {
    const auto picture = s.mixed(&measured, noise);
    if (!picture) return fail(picture.error());
    return right_of(
        bare, target, [&] { return s.show(**picture, target); }, [&] { return s.show(s.mix->background(), target); });
  }
  if (auto followed = s.follow_matte(); !followed) return followed;
  const auto processed = s.process(measured, noise);
  if (!processed) return fail(processed.error());
  const TargetPlacement shown(target, s.camera.newest().width, s.camera.newest().height);
  if (!*processed)
    if (auto done = s.composite.finish(s.programs, s.frame(), shown, *s.layer, measured, noise, s.info); !done)
      return done;
  shown.begin(target, false);
  return right_of(
      bare, target,
      [&] { return s.composite.draw(s.programs, s.frame(), shown, *s.layer, measured, noise, *processed); },
      [&] { return s.composite.draw_camera_alone(s.programs, s.frame(), shown); });
}

void Renderer::set_bare(double share) {
  state_->bare = std::clamp(share, 0.0, 1.0);
}

bool Renderer::processor_mixes() const {
  return state_->mix.has_value();
}

Result<const Image<glm::u8vec4>*> Renderer::mix(const AirlightGrid& measured, const SensorNoise& noise) {
  State& s = *state_;
  if (!s.mixes()) return fail(FaultKind::unsupported, "pictures are mixed by the GPU");
  if (auto ready = s.ready_for_layer(measured, {0, 1, 1, true}, noise); !ready) return fail(ready.error());
  return s.mixed(&measured, noise);
}

Result<const Image<glm::u8vec4>*> Renderer::mix_background() {
  State& s = *state_;
  if (!s.mixes()) return fail(FaultKind::unsupported, "pictures are mixed by the GPU");
  return s.mixed(nullptr, {});
}

Result<> Renderer::set_in_front(const InFront& passers) {
  State& s = *state_;
  s.passers.clear();
  if (s.mix) s.mix->take_passers(passers);
  if (passers.pixels.empty()) return {};
  if (const int most = s.info.max_texture_size; passers.pixels.width() > most || passers.pixels.height() > most)
    return fail(FaultKind::bad_input, "{} x {} pixels in front of the object: this driver supports at most {}",
                passers.pixels.width(), passers.pixels.height(), most);
  return s.passers.upload(passers);
}

Result<> Renderer::draw_for_plane(const AirlightGrid& measured, const DrawTarget& target, const SensorNoise& noise) {
  State& s = *state_;
  const PixelBox& box = s.box;
  if (!s.layer || target.width != box.right - box.left || target.height != box.bottom - box.top ||
      !target.top_row_first)
    return fail(FaultKind::bad_input, "a plane of {} x {} pixels: the object's box is of {} x {}", target.width,
                target.height, box.right - box.left, box.bottom - box.top);
  if (auto ready = s.ready_for_layer(measured, target, noise); !ready) return ready;
  if (auto there = s.picture_on_gpu(); !there) return there;
  if (auto followed = s.follow_matte(); !followed) return followed;
  const auto processed = s.process(measured, noise);
  if (!processed) return fail(processed.error());
  const TargetPlacement shown(box, s.camera.newest().width, s.camera.newest().height);
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT);
  glViewport(shown.box.x, shown.box.y, shown.box.width, shown.box.height);
  return s.composite.draw_for_plane(s.programs, s.frame(), shown, *s.layer, measured, noise, *processed);
}

PixelBox Renderer::drawn_box() const {
  return state_->composite.covered();
}

bool Renderer::has_matte() const {
  return state_->composite.is_left_open();
}

Result<> Renderer::draw_moving(const ObjectAppearance& appearance, const AirlightGrid& measured,
                               const DrawTarget& target, HazeDetail detail) {
  State& s = *state_;
  if (auto ready = s.ready_for_object(); !ready) return ready;
  if (auto ready = s.ready_for_frame(target); !ready) return ready;
  Problems problems;
  check(appearance, problems);
  check(measured, "measured airlight", false, problems);
  if (!problems.empty()) return fail(problems.fault());

  if (auto there = s.picture_on_gpu(); !there) return there;
  if (auto lit = s.follow(appearance.light); !lit) return lit;
  const auto drawn_shadow = s.shadow_under(appearance);
  if (!drawn_shadow) return fail(drawn_shadow.error());
  const SunShadow* shadow = detail == HazeDetail::per_vertex || s.many_varyings ? *drawn_shadow : nullptr;
  const TargetPlacement shown(target, s.camera.newest().width, s.camera.newest().height);
  shown.begin(target, true);
  Defines defines{"FINAL_COLOUR", s.response->define()};
  if (shadow) defines.merge(shadow->defines());
  defines.merge(s.camera.newest().defines());
  if (!appearance.aerial_perspective)
    defines.insert("NO_AIR");
  else if (detail == HazeDetail::per_fragment)
    defines.insert("HAZE_PER_FRAGMENT");
  if (appearance.aerial_perspective && appearance.haze.fog_per_m > 0.0) defines.insert("FOG_LIGHT");
  if (measured.saturates()) defines.insert("SATURATED");
  if (s.foreground) defines.insert("FOREGROUND");
  if (s.projection->distorted) defines.insert("DISTORTED");
  if (s.foreground) s.foreground->bind();
  const DepthRange depth = depth_range(*s.projection, s.model->bounds_with_ground());
  glFrontFace(s.projection->mirrored == target.top_row_first ? GL_CCW : GL_CW);
  const auto set_uniforms = [&](const Program& program) {
    s.frame().bind(program, shown);
    set_projection(program, *s.projection, depth);
    set_appearance(program, appearance);
    s.sky.bind(program, s.units_in_one_pass.sky);
    if (shadow) shadow->bind(program, kShadowUnit);
    set_airlight(program, "measured", measured);
    program.set("foreground", kForegroundUnit);
    program.set("fragment_to_picture", shown.fragment_to_picture);
  };
  // Nearest first, so that the early depth test skips the background behind the object.
  const auto draw_model = [&](GpuModel::Which which) {
    return s.model->draw(which, s.programs, defines, s.units_in_one_pass, {}, set_uniforms);
  };
  if (auto drawn = draw_model(GpuModel::Which::solid); !drawn) return drawn;
  if (shadow)
    if (auto drawn = draw_model(GpuModel::Which::ground); !drawn) return drawn;
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LEQUAL);
  glDepthMask(GL_FALSE);
  const auto background = s.composite.draw_camera_alone(s.programs, s.frame(), shown);
  glDisable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  if (!background || !s.model->has_blended()) return background;
  return draw_model(GpuModel::Which::blended);
}

const std::vector<std::string>& Renderer::notes() const {
  return state_->notes;
}

}  // namespace kasumi
