#include "gles/composite/composite.hpp"

#include <algorithm>
#include <utility>

#include "gles/gl/gl.hpp"
#include "gles/gl/patterns.hpp"
#include "gles/gl/texture_units.hpp"
#include "gles/gpu_model/projection.hpp"
#include "gles/light/airlight_grid.hpp"

namespace kasumi {

namespace {

// The smallest box, in pixels of the picture, that holds every pixel with something of the object.
PixelBox box_of(const Image<float>& coverage, const PixelBox& all) {
  PixelBox box{all.right, all.bottom, all.left, all.top};
  for (int y = 0; y < coverage.height(); ++y)
    for (int x = 0; x < coverage.width(); ++x) {
      if (coverage.at(x, y) <= 0.0f) continue;
      box.left = std::min(box.left, all.left + x);
      box.right = std::max(box.right, all.left + x + 1);
      box.top = std::min(box.top, all.top + y);
      box.bottom = std::max(box.bottom, all.top + y + 1);
    }
  return box.empty() ? PixelBox{} : box;
}

// Of the pixels that are covered wholly, by rows.
std::vector<PixelBox> full_runs(const Image<float>& coverage, const PixelBox& all) {
  std::vector<PixelBox> runs;
  for (int y = 0; y < coverage.height(); ++y)
    for (int x = 0; x < coverage.width(); ++x) {
      if (coverage.at(x, y) < 1.0f) continue;
      const int first = x;
      while (x < coverage.width() && coverage.at(x, y) >= 1.0f) ++x;
      runs.push_back({all.left + first, all.top + y, all.left + x, all.top + y + 1});
    }
  return runs;
}

// A texture unit that this picture leaves free; < 0: none.
int unit_for_nodes(const FrameInputs& frame, bool noise_unit_is_free) {
  if (frame.spare_unit >= 0) return frame.spare_unit;
  if (noise_unit_is_free) return kNoiseUnit;
  if (frame.response.define() != "RESPONSE_TABLE") return kResponseUnit;
  return frame.camera.count() < 3 ? kPlaneUnit + 2 : -1;
}

}  // namespace

void FrameInputs::bind(const Program& program, const TargetPlacement& shown) const {
  camera.bind(program, !shown.same_size);
  response.bind(program, kResponseUnit);
  glActiveTexture(GL_TEXTURE0 + kDitherUnit);
  glBindTexture(GL_TEXTURE_2D, dither.name());
  program.set("dither_pattern", kDitherUnit);
  program.set("picture_size", glm::dvec2{camera.width, camera.height});
  program.set("pixel_to_clip", shown.pixel_to_clip);
}

void Composite::take(const ObjectLayer& layer, const SceneView& view, const Image<glm::vec4>& texels,
                     const Foreground* foreground) {
  Image<float> coverage(texels.width(), texels.height());
  for (std::size_t i = 0; i < coverage.elements().size(); ++i) coverage.elements()[i] = texels.elements()[i].a;
  covered_ = box_of(coverage, layer.box());
  is_left_open_ = false;
  if (foreground)
    for (int y = 0; y < coverage.height(); ++y)
      for (int x = 0; x < coverage.width(); ++x) {
        if (coverage.at(x, y) <= 0.0f || !foreground->is_mixed(layer.box().left + x, layer.box().top + y)) continue;
        is_left_open_ = true;
        coverage.at(x, y) *= 0.5f;
      }
  fully_covered_ = full_runs(coverage, layer.box());
  rectangles_ = cut_picture(view.width, view.height, layer.box(), coverage);
  mesh_ = {};
  part_ = {};
  finished_.clear();
  for_processor_.clear();
}

std::vector<PixelBox> Composite::changed() const {
  std::vector<PixelBox> all = rectangles_[static_cast<std::size_t>(CutArea::covered)];
  const auto& edges = rectangles_[static_cast<std::size_t>(CutArea::edge)];
  all.insert(all.end(), edges.begin(), edges.end());
  return all;
}

// Grids rarely move between frames, so a mesh is seldom rebuilt.
const PictureMesh& Composite::CutMesh::at(const AirlightGrid& wanted, const CutRectangles& rectangles) {
  if (!mesh || wanted.first_px != grid.first_px || wanted.last_px != grid.last_px)
    mesh = PictureMesh::upload(cut_at_lines(rectangles, wanted));
  grid = wanted;
  return *mesh;
}

Composite::Part& Composite::part_in(const std::vector<PixelBox>& boxes) {
  if (part_.camera && part_.boxes == boxes) return part_;
  part_ = {boxes, PictureMesh::upload({boxes}), {}, {}};
  for (std::size_t area = 0; area < kCutAreas; ++area)
    for (const PixelBox& rectangle : rectangles_[area])
      for (const PixelBox& box : boxes)
        if (overlap(rectangle, box)) part_.rectangles[area].push_back(common(rectangle, box));
  return part_;
}

const PictureMesh& Composite::mesh_for(const AirlightGrid& grid, Part* part) {
  return part ? part->mesh.at(grid, part->rectangles) : mesh_.at(grid, rectangles_);
}

void Composite::bind_noise(const Program& program, const SensorNoise& noise, bool smooth) {
  if (!noise_) noise_ = make_noise_pattern();
  glActiveTexture(GL_TEXTURE0 + kNoiseUnit);
  glBindTexture(GL_TEXTURE_2D, noise_.name());
  set_filter(smooth ? TextureFilter::linear : TextureFilter::nearest);
  program.set("noise_pattern", kNoiseUnit);
  program.set("noise_shot", noise.shot);
  program.set("noise_read2", noise.read * noise.read);
  program.set("noise_place", glm::dvec3(noise_start(noise.pattern % kNoisePatterns), 1.0 / kNoiseSize));
}

Result<> Composite::draw_camera_on(const PictureMesh& mesh, Programs& programs, const FrameInputs& frame,
                                   const TargetPlacement& shown) {
  const auto program = programs.find(ProgramKind::picture, frame.camera.defines());
  if (!program) return fail(program.error());
  (*program)->use();
  frame.bind(**program, shown);
  mesh.draw(CutArea::plain);
  return check_gl("drawing the camera's picture");
}

Result<> Composite::draw_camera_alone(Programs& programs, const FrameInputs& frame, const TargetPlacement& shown) {
  const glm::ivec2 size{frame.camera.width, frame.camera.height};
  if (!whole_ || whole_size_ != size) whole_ = PictureMesh::upload(cut_picture(size.x, size.y, {}, {}));
  whole_size_ = size;
  return draw_camera_on(*whole_, programs, frame, shown);
}

Result<> Composite::draw_camera_in(const std::vector<PixelBox>& parts, Programs& programs, const FrameInputs& frame,
                                   const TargetPlacement& shown) {
  return draw_camera_on(*part_in(parts).camera, programs, frame, shown);
}

// Areas that do not need the camera or its response share one variant.
Result<> Composite::draw_area(CutArea area, Part* part, Defines defines, Programs& programs, const FrameInputs& frame,
                              const TargetPlacement& shown, const ObjectLayer& layer, const AirlightGrid& measured,
                              const SensorNoise& noise, const CameraProcessing* processing) {
  const PictureMesh& mesh = mesh_for(measured, part);
  if (mesh.empty(area)) return {};
  // With passers before it, all of the object is drawn as an edge.
  const bool somebody = area != CutArea::plain && frame.passers;
  const bool covered = area == CutArea::covered && !somebody;
  if (!covered) defines.merge(frame.camera.defines());
  if (covered) defines = {"COVERED", "LAYOUT_RGB"};
  if (area != CutArea::plain && !covered) defines.insert("EDGE");
  // Then the result of the processing is all that is needed.
  const bool looked_up = processing && !defines.contains("PLANE");
  if (area != CutArea::plain && !looked_up) {
    defines.insert(frame.response.define());
    if (measured.saturates()) defines.insert("SATURATED");
  }
  const bool noisy = !noise.none() && !processing;
  if (area != CutArea::plain && noisy) defines.insert("NOISE");
  if (area != CutArea::plain && processing) defines.insert("PROCESSED");
  const bool matte = area == CutArea::edge && frame.foreground && !looked_up;
  const bool passers = somebody && !looked_up;
  // Before the processing as after it, or the two would not agree on what the leaves cover.
  const bool noise_unit_is_free = noise.none() && !processing && !defines.contains("COVERAGE");
  int nodes_unit = matte && frame.matte ? unit_for_nodes(frame, noise_unit_is_free) : -1;
  int passers_unit = matte ? frame.passers_unit : static_cast<int>(kForegroundUnit);
  if (passers && passers_unit < 0) passers_unit = std::exchange(nodes_unit, -1);  // leaves are mixed by the mask
  if (matte) defines.insert("MATTE");
  if (nodes_unit >= 0) defines.insert("MATTE_NODES");
  if (passers && passers_unit >= 0) defines.insert("IN_FRONT");
  const auto program = programs.find(ProgramKind::picture, defines);
  if (!program) return fail(program.error());
  (*program)->use();
  frame.bind(**program, shown);
  if (area != CutArea::plain) {
    layer.bind(**program, !shown.same_size);
    set_airlight(**program, "measured", measured);
    if (noisy) bind_noise(**program, noise, !shown.same_size);
    if (processing) processing->bind(**program, !shown.same_size);
  }
  if (matte) {
    frame.foreground->bind();
    (*program)->set("foreground", kForegroundUnit);
  }
  if (passers && passers_unit >= 0)
    frame.passers->bind(**program, passers_unit, frame.camera.width, frame.camera.height);
  if (nodes_unit >= 0) frame.matte->bind(**program, nodes_unit, frame.camera.width, frame.camera.height);
  mesh.draw(area);
  return {};
}

Result<> Composite::finish(Programs& programs, const FrameInputs& frame, const TargetPlacement& shown,
                           const ObjectLayer& layer, const AirlightGrid& measured, const SensorNoise& noise,
                           const GlInfo& info) {
  is_finished_ = false;
  if (frame.passers || mesh_for(measured, nullptr).empty(CutArea::covered)) return {};
  const auto found = finished_.find(shown, covered_, {measured, noise}, info, [&] {
    return draw_area(CutArea::covered, nullptr, {}, programs, frame, shown, layer, measured, noise, nullptr);
  });
  if (!found) return fail(found.error());
  is_finished_ = *found;
  return {};
}

Result<CoveredPixels> Composite::covered_pixels(Programs& programs, const FrameInputs& frame, const ObjectLayer& layer,
                                                const AirlightGrid& measured, const SensorNoise& noise,
                                                const GlInfo& info) {
  if (frame.passers || fully_covered_.empty()) return CoveredPixels{};
  // The camera has no part in these pixels, but edges are drawn by another program than covered rectangles. Texture 0
  // stands for the camera's picture: black.
  const CameraTextures none{CameraTextures::Source::uploaded,
                            PixelLayout::rgb8,
                            YuvEncoding::bt601_full,
                            frame.camera.width,
                            frame.camera.height,
                            {}};
  const FrameInputs alone{none, frame.response, frame.dither};
  const TargetPlacement shown(covered_, none.width, none.height);
  std::uint64_t& drawing = drawing_of_[noise.none() ? 0 : noise.pattern % kNoisePatterns];
  const auto draw_covered = [&]() -> Result<> {
    drawing = ++drawings_;
    for (const CutArea area : {CutArea::covered, CutArea::edge})
      if (auto drawn = draw_area(area, nullptr, {}, programs, alone, shown, layer, measured, noise, nullptr); !drawn)
        return drawn;
    return {};
  };
  const auto found = for_processor_.find(shown, covered_, {measured, noise}, info, draw_covered);
  if (!found) return fail(found.error());
  if (*found) {
    const auto kept = for_processor_.read();
    if (!kept) return fail(kept.error());
    return CoveredPixels{*kept, drawing};
  }
  const int width = covered_.right - covered_.left, height = covered_.bottom - covered_.top;
  const auto buffer = LayerBuffer::create(width, height, true, info, "the object's pixels");
  if (!buffer) return fail(buffer.error());
  glViewport(shown.box.x, shown.box.y, shown.box.width, shown.box.height);
  if (auto drawn = draw_covered(); !drawn) return fail(drawn.error());
  auto pixels = read_pixels(*buffer, width, height);
  if (!pixels) return fail(pixels.error());
  not_kept_ = std::move(*pixels);
  return CoveredPixels{&not_kept_, drawing};
}

Result<> Composite::draw_finished(Programs& programs, const FrameInputs& frame, const TargetPlacement& shown) {
  const auto program = programs.find(ProgramKind::picture, {"COVERED", "LAYOUT_RGB", "PROCESSED"});
  if (!program) return fail(program.error());
  (*program)->use();
  frame.bind(**program, shown);
  finished_.bind(**program);
  mesh_.mesh->draw(CutArea::covered);
  return {};
}

Result<> Composite::draw(Programs& programs, const FrameInputs& frame, const TargetPlacement& shown,
                         const ObjectLayer& layer, const AirlightGrid& measured, const SensorNoise& noise,
                         const CameraProcessing* processing) {
  const bool finished = is_finished_ && !processing;
  for (const CutArea area : {CutArea::plain, CutArea::covered, CutArea::edge}) {
    auto drawn = finished && area == CutArea::covered
                     ? draw_finished(programs, frame, shown)
                     : draw_area(area, nullptr, {}, programs, frame, shown, layer, measured, noise, processing);
    if (!drawn) return drawn;
  }
  return check_gl("drawing the picture");
}

Result<> Composite::draw_with_coverage(const std::vector<PixelBox>* only, Programs& programs, const FrameInputs& frame,
                                       const TargetPlacement& shown, const ObjectLayer& layer,
                                       const AirlightGrid& measured, const SensorNoise& noise) {
  Part* part = only ? &part_in(*only) : nullptr;
  for (const CutArea area : {CutArea::plain, CutArea::covered, CutArea::edge})
    if (auto drawn = draw_area(area, part, {"COVERAGE"}, programs, frame, shown, layer, measured, noise, nullptr);
        !drawn)
      return drawn;
  return check_gl("drawing the picture for its processing");
}

Result<> Composite::draw_for_plane(Programs& programs, const FrameInputs& frame, const TargetPlacement& shown,
                                   const ObjectLayer& layer, const AirlightGrid& measured, const SensorNoise& noise,
                                   const CameraProcessing* processing) {
  for (const CutArea area : {CutArea::covered, CutArea::edge})
    if (auto drawn = draw_area(area, nullptr, {"PLANE"}, programs, frame, shown, layer, measured, noise, processing);
        !drawn)
      return drawn;
  return check_gl("drawing the building for a plane");
}

}  // namespace kasumi
