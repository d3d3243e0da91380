#include "pipeline/show/scene/compositor.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <spdlog/spdlog.h>
#include <glm/geometric.hpp>

#include "pipeline/show/scene/for_gles.hpp"

namespace kasumi {

namespace {

// Of a picture's time, for a layer that is being redrawn.
constexpr Duration kSlice = std::chrono::milliseconds(4);
constexpr int kAroundBuilding_px = 32;  // in which the light around the building is seen, and who comes
constexpr Duration kAnswerBound = std::chrono::seconds(20);  // whoever was asked has died of the question

ExternalPicture external(const PictureView& view, const DmaBuf& memory) {
  ExternalPicture picture{memory.fd, memory.buffer, view.layout, view.encoding, view.width, view.height, {}};
  for (std::size_t i = 0; i < static_cast<std::size_t>(plane_count(view.layout)); ++i)
    picture.planes[i] = {memory.offset + static_cast<std::uint32_t>(view.planes[i].data - view.planes[0].data),
                         static_cast<std::uint32_t>(view.planes[i].stride)};
  return picture;
}

}  // namespace

Result<Compositor> Compositor::create(GlContext& context, const Installation& installation, SceneAirOptions options) {
  auto model = read_gltf(installation.object.model, {}, installation.object.scene);
  if (!model) return fail(model.error());
  for (const auto& note : model->notes) spdlog::info("{}", note);
  return create(context, installation, *model, options);
}

Result<Compositor> Compositor::create(GlContext& context, const Installation& installation, const Model& model,
                                      SceneAirOptions options) {
  return create(context, installation, model, SceneAir(installation, options));
}

Result<Compositor> Compositor::create(GlContext& context, const Installation& installation, const Model& model,
                                      SceneAir air, const RendererOptions& options) {
  auto making = CompositorMaking::begin(context, installation, model, nullptr, std::move(air), options);
  if (!making) return fail(making.error());
  for (;;) {
    const auto whole = making->step();
    if (!whole) return fail(whole.error());
    if (*whole) return making->take();
  }
}

PreparedScene prepare_scene(const Installation& installation, const Model& model) {
  PreparedScene prepared{cut_model(model), depth_for_gles(installation.scene, installation.scene_distances_m), nullptr};
  if (!installation.object.shadows || !installation.object.ground_light || model.ground.empty()) return prepared;
  auto ground = std::make_shared<GroundWatch>(installation.scene, model, installation.object.placement);
  if (!ground->empty()) prepared.ground = std::move(ground);
  return prepared;
}

Result<CompositorMaking> CompositorMaking::begin(GlContext& context, const Installation& installation,
                                                 const Model& model, std::shared_ptr<const PreparedScene> prepared,
                                                 SceneAir air, const RendererOptions& options) {
  if (auto sound = check(model); !sound) return fail(sound.error());
  if (!prepared) prepared = std::make_shared<const PreparedScene>(prepare_scene(installation, model));
  auto renderer = Renderer::create(context, options);
  if (!renderer) return fail(renderer.error());
  const bool reflects = std::ranges::any_of(model.materials, &ModelMaterial::reflects);
  auto filters = reflects ? std::async(std::launch::async, prepare_sky_squares) : std::future<void>();
  const std::shared_ptr<const ModelChunks> chunks(prepared, &prepared->chunks);
  if (auto begun = renderer->begin_model(model, chunks); !begun) return fail(begun.error());
  Compositor made(std::move(*renderer), std::move(air), installation);
  made.filters_ = std::move(filters);
  made.ground_ = prepared->ground;
  return CompositorMaking(std::move(made), installation, model, std::move(prepared));
}

Result<bool> CompositorMaking::step() {
  const auto whole = made_.renderer_.continue_model();
  if (!whole || !*whole) return whole;
  if (auto set = set_scene(); !set) return fail(set.error());
  prepared_.reset();
  return true;
}

Result<> CompositorMaking::set_scene() {
  Renderer& renderer = made_.renderer_;
  const Camera& scene = installation_->scene;
  const auto to_world = model_to_world(installation_->object.placement);
  const auto bounds = model_->bounds_with_ground();
  const glm::dvec3 lowest(bounds.lowest), highest(bounds.highest);
  const glm::dvec3 centre(to_world * glm::dvec4(0.5 * (lowest + highest), 1.0));
  const double radius = 0.5 * glm::length(highest - lowest) * installation_->object.placement.scale;
  if (auto set = renderer.set_view(view_for_gles(scene, centre, radius), to_world); !set) return set;
  if (auto set = renderer.set_foreground(scene.mask, installation_->scene_quality.point_spread_px); !set) return set;
  if (auto set = renderer.set_scene_depth(prepared_->depth_m); !set) return set;
  return renderer.set_response(response_for_gles(scene.response));
}

Result<> Compositor::draw(const Frame& frame, const SkyReport& sky, const DrawTarget& target) {
  const auto picture = decode(frame, encoding_);
  if (!picture) return fail(picture.error());
  return draw(frame.metadata, *picture, sky, target);
}

Result<> Compositor::draw(const FrameMetadata& metadata, const DecodedPicture& picture, const SkyReport& sky,
                          const DrawTarget& target) {
  if (auto taken = pass_to_gpu(picture); !taken) return taken;
  if (auto followed = follow(metadata, picture, sky); !followed) return followed;
  drawn_ = true;
  return show(target);
}

// The air that the frame is drawn under, and the building's layer, which does not need the horizon as it is seen.
Result<> Compositor::follow(const FrameMetadata& metadata, const DecodedPicture& picture, const SkyReport& sky) {
  const auto now = air_.conditions(sky);
  air_.follow_exposure(metadata);
  auto horizon = measure_horizon(metadata, picture, sky, now);
  const auto wanted = detail_for_gles(quality_, picture.view().layout, now.haze_blur_px);
  noise_ = noise_for_gles(quality_, white_balance_, metadata.gain.value_or(1.0), metadata.sequence);
  if (ground_ && !clock_) {  // the layer is to know how this picture's ground is lit
    if (horizon.valid()) air_.adopt(horizon.get());
    if (auto fitted = update_detail(wanted); !fitted) return fitted;
    look_at_ground(metadata, picture, now);
  }
  auto updated = clock_ && layer_ ? update_layer_in_slices(metadata, now, wanted) : update_layer_at_once(now, wanted);
  if (horizon.valid()) air_.adopt(horizon.get());
  measured_ = air_.measured(now, renderer_.object_box());
  if (question_ && ground_ && appearance_) question_->ground = GroundQuestion{ground_, appearance_, *measured_};
  if (!updated) return updated;
  return keep_passers_in_front(metadata, picture);
}

Result<> Compositor::keep_passers_in_front(const FrameMetadata& metadata, const DecodedPicture& picture) {
  outline_ = 0;
  const PixelBox box = renderer_.object_box();
  if (!people_in_front_ || box.empty()) {
    passers_.reset();
    return renderer_.set_in_front({});
  }
  const auto place = part_around(box.left, box.top, box.right, box.bottom, kAroundBuilding_px, width_, height_);
  if (!passers_ || passers_->place() != place) passers_.emplace(place, response_);
  const auto& in_front = passers_->look(picture.view(), metadata.captured_at).in_front;
  if (!in_front.empty()) outline_ = ++outlines_;
  return renderer_.set_in_front({in_front.left, in_front.top, in_front.pixels});
}

ObjectAppearance Compositor::lit_appearance(const SceneConditions& now) const {
  ObjectAppearance appearance = air_.appearance(now, renderer_.object_box());
  light_ground(appearance, ground_look_);
  return appearance;
}

void Compositor::look_at_ground(const FrameMetadata& metadata, const DecodedPicture& picture,
                                const SceneConditions& now) {
  const PixelBox box = renderer_.object_box();
  if (!(appearance_ && layer_ && look_alike(now, *layer_)))
    appearance_ = std::make_shared<const ObjectAppearance>(air_.appearance(now, box));
  ground_->see(picture.view(), metadata, *appearance_, air_.measured(now, box));
  ground_->shade_foot(true);
  ground_look_ = ground_->look();
}

void Compositor::adopt(const HorizonAnswer& answer) {
  air_.adopt(answer);
  if (answer.watch && answer.watch == ground_) ground_look_ = answer.ground;
}

// Beside the drawing; once it is live, by somebody else.
std::future<HorizonAnswer> Compositor::measure_horizon(const FrameMetadata& metadata, const DecodedPicture& picture,
                                                       const SkyReport& sky, const SceneConditions& now) {
  if (!air_.horizon_is_due(metadata)) return {};
  if (!clock_ || !air_.horizon().usable())
    return std::async(std::launch::async, [&metadata, &picture, &now, sky = sky.picture, observer = air_.observer(),
                                           box = renderer_.object_box()] {
      return answer(observer, metadata, picture.view(), sky ? &sky->view() : nullptr, now, box);
    });
  air_.asked(metadata);
  question_ = HorizonQuestion{air_.observer(), metadata, CopiedPicture(picture.view()),
                              sky.picture,     now,      renderer_.object_box()};
  return {};
}

Result<> Compositor::update_layer_at_once(const SceneConditions& now, const ObjectDetail& wanted) {
  if (auto fitted = update_detail(wanted); !fitted) return fitted;
  if (!unfinished_layer_ && !(layer_ && look_alike(now, *layer_) && look_alike(ground_look_, layer_ground_)))
    if (auto begun = begin_layer(now, lit_appearance(now), ground_look_); !begun) return begun;
  while (unfinished_layer_)
    if (const auto whole = continue_layer(); !whole) return fail(whole.error());
  return {};
}

// One layer at a time: asked for, answered, drawn, and then the next that is due.
Result<> Compositor::update_layer_in_slices(const FrameMetadata& metadata, const SceneConditions& now,
                                            const ObjectDetail& wanted) {
  const auto age = asked_layer_ ? metadata.captured_at - asked_layer_->at : Duration::zero();
  if (age > kAnswerBound || age < Duration::zero()) asked_layer_.reset();
  if (!unfinished_layer_ && layer_answer_) {
    const auto answer = std::exchange(layer_answer_, std::nullopt);
    if (auto begun = begin_layer(answer->conditions, answer->appearance, answer->ground, {answer->detail, answer->sky});
        !begun)
      return begun;
  }
  if (unfinished_layer_) {
    const auto began = clock_->now();
    if (const auto whole = continue_layer([&] { return clock_->now() - began < kSlice; }); !whole)
      return fail(whole.error());
  }
  if (!unfinished_layer_ && !asked_layer_ &&
      (wanted != detail_ || !look_alike(now, *layer_) || !look_alike(ground_look_, layer_ground_))) {
    const auto air = std::make_shared<const SceneAir>(air_);
    layer_question_ = LayerQuestion{air, now, wanted, renderer_.object_box(wanted), renderer_.reflects(), ground_look_};
    asked_layer_ = AskedLayer{air, metadata.captured_at};
  }
  return {};
}

void Compositor::adopt(LayerAnswer answer) {
  if (!asked_layer_ || answer.air != asked_layer_->air) return;
  asked_layer_.reset();
  layer_answer_ = std::move(answer);
}

Result<> Compositor::take(const FrameMetadata& metadata, const DecodedPicture& picture, const SkyReport& sky) {
  if (auto lent = lend(picture); !lent) return lent;
  return follow(metadata, picture, sky);
}

Result<> Compositor::take_without_object(const DecodedPicture& picture) {
  measured_.reset();
  return lend(picture);
}

Result<> Compositor::lend(const DecodedPicture& picture) {
  const auto& view = picture.view();
  if (view.width != width_ || view.height != height_)
    return fail(FaultKind::bad_input, "camera picture of {} x {} pixels: the view is of {} x {}", view.width,
                view.height, width_, height_);
  if (!picture.dma_buf()) return fail(FaultKind::bad_input, "the camera's picture is not in a driver's buffer");
  lent_ = picture;
  lent_to_gpu_ = false;
  camera_buffer_ = external(view, *picture.dma_buf());
  drawn_ = true;
  return {};
}

std::optional<BuildingLook> Compositor::look() const {
  if (!measured_) return std::nullopt;
  return BuildingLook{layers_drawn_, *measured_, noise_, outline_};
}

Result<> Compositor::draw_for_plane(const DrawTarget& target) {
  if (lent_ && !lent_to_gpu_)
    if (auto passed = pass_to_gpu(DecodedPicture(*lent_)); !passed) return passed;
  return renderer_.draw_for_plane(*measured_, target, noise_);
}

// Rarely does anything: the layout is known from the first frame on, and the air changes within hours.
Result<> Compositor::update_detail(const ObjectDetail& wanted) {
  if (wanted == detail_) return {};
  if (auto set = renderer_.set_detail(wanted); !set) return set;
  detail_ = wanted;
  layer_.reset();
  unfinished_layer_.reset();
  return {};
}

Result<> Compositor::begin_layer(const SkyReport& sky, PixelLayout layout) {
  const auto now = air_.conditions(sky);
  if (auto fitted = update_detail(detail_for_gles(quality_, layout, now.haze_blur_px)); !fitted) return fitted;
  measured_ = air_.measured(now, renderer_.object_box());
  return begin_layer(now, lit_appearance(now), ground_look_);
}

Result<> Compositor::begin_layer(const SceneConditions& now, ObjectAppearance appearance, const GroundLook& ground,
                                 const WithLayer& with) {
  unfinished_layer_.reset();
  if (auto begun = renderer_.begin_layer(appearance, with); !begun) return begun;
  appearance_ = std::make_shared<const ObjectAppearance>(std::move(appearance));
  unfinished_layer_ = UnfinishedLayer{now, with.detail.value_or(detail_), ground};
  return {};
}

Result<bool> Compositor::continue_layer() {
  return continue_layer({});
}

Result<bool> Compositor::continue_layer(const std::function<bool()>& time_is_left) {
  const auto whole = renderer_.continue_layer(time_is_left);
  if (!whole) unfinished_layer_.reset();
  if (!whole || !*whole) return whole;
  layer_ = unfinished_layer_->conditions;
  layer_ground_ = unfinished_layer_->ground;
  detail_ = unfinished_layer_->detail;
  unfinished_layer_.reset();
  ++layers_drawn_;
  return true;
}

Result<> Compositor::rehearse(PixelLayout layout, const DrawTarget& target) {
  PictureView grey{layout, encoding_, width_, height_, {}};
  const auto planes = static_cast<std::size_t>(plane_count(layout));
  std::array<std::vector<std::uint8_t>, 3> bytes;
  for (std::size_t i = 0; i < planes; ++i) {
    const auto size = plane_size(layout, width_, height_, static_cast<int>(i));
    bytes[i].assign(size.row_bytes * static_cast<std::size_t>(size.rows), 128);
    grey.planes[i] = {bytes[i].data(), size.row_bytes};
  }
  if (auto uploaded = renderer_.upload(grey, detail_.jpeg_blocks ? std::make_shared<const JpegSteps>() : nullptr);
      !uploaded)
    return uploaded;
  noise_ = noise_for_gles(quality_, white_balance_, 1.0, 0);
  auto drawn = show(target);
  // Somebody in front is drawn by programs of their own, which must not be compiled when the first comes.
  if (drawn && people_in_front_) {
    InFront somebody;
    somebody.pixels = Image<glm::u8vec4>(3, 3, glm::u8vec4{0, 0, 0, 255});
    if (auto set = renderer_.set_in_front(somebody); !set) return set;
    drawn = show(target);
    if (auto set = renderer_.set_in_front({}); !set) return set;
  }
  measured_.reset();
  return drawn;
}

Result<> Compositor::draw_without_object(const DecodedPicture& picture, const DrawTarget& target) {
  if (auto taken = pass_to_gpu(picture); !taken) return taken;
  measured_.reset();
  drawn_ = true;
  return show(target);
}

Result<> Compositor::pass_to_gpu(const DecodedPicture& picture) {
  if (picture.dma_buf() && renderer_.import_frame(external(picture.view(), *picture.dma_buf()))) {
    lent_ = picture;
    lent_to_gpu_ = true;
    return {};
  }
  if (auto uploaded = renderer_.upload(picture.view(), picture.jpeg_steps()); !uploaded) return uploaded;
  lent_.reset();
  return {};
}

Result<> Compositor::draw_again(const DrawTarget& target) {
  if (!drawn_) return fail(FaultKind::bad_input, "no frame of the scene camera has been drawn yet");
  if (auto copied = copy_lent(); !copied) return copied;
  return show(target);
}

Result<> Compositor::copy_lent() {
  if (!lent_) return {};
  if (auto copied = renderer_.upload(lent_->view(), lent_->jpeg_steps()); !copied) return copied;
  lent_.reset();
  return {};
}

Result<> Compositor::drop_camera_buffers() {
  if (auto copied = copy_lent(); !copied) return copied;
  renderer_.drop_camera_buffers();
  return {};
}

Result<> Compositor::show(const DrawTarget& target) {
  return measured_ ? renderer_.draw(*measured_, target, noise_) : renderer_.draw_background(target);
}

}  // namespace kasumi
