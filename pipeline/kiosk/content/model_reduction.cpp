#include "pipeline/kiosk/content/model_reduction.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/files.hpp"
#include "gles/gl/context.hpp"
#include "gles/model/coarser_model.hpp"
#include "gles/model/mip_levels.hpp"
#include "gles/model/write_gltf.hpp"
#include "pipeline/kiosk/content/reduction_loss.hpp"
#include "pipeline/kiosk/content/texture_file.hpp"
#include "pipeline/site/config/sighting.hpp"

namespace kasumi {

namespace {

namespace fs = std::filesystem;

// In pixels of the scene camera, the coarsest first. A texel of a quarter of a pixel: what drawing filters from stays sharp.
// Without an error only textures are reduced.
struct PixelCoarseness {
  double error, relief, texel;
};
constexpr PixelCoarseness kCoarsenesses[]{{0.25, 0.5, 0.5},   {0.12, 0.5, 0.25},  {0.06, 0.5, 0.25},
                                          {0.02, 0.25, 0.25}, {0.01, 0.25, 0.25}, {0.005, 0.25, 0.25},
                                          {0.0, 0.0, 0.5},    {0.0, 0.0, 0.25}};
constexpr double kWorthwhile = 0.8;  // of triangles or texels: with more left a model stays as it is

// A model file of the content, and all scenes of it that are shown.
struct ShownModel {
  fs::path file;
  struct Scene {
    std::string name;  // as it is configured
    std::shared_ptr<const Model> model;
  };
  std::vector<Scene> scenes;
  const Model& first() const { return *scenes.front().model; }
};

// The places that stories name; a model's other nodes are not written.
std::vector<ModelNode> nodes_of_stories(const Model& model, const VisitorContent* visitor) {
  std::vector<ModelNode> nodes;
  if (visitor)
    for (const Story& story : visitor->stories)
      if (const auto at = place_of(story, model);
          at && !story.node.empty() && std::ranges::find(nodes, story.node, &ModelNode::name) == nodes.end())
        nodes.push_back({story.node, *at});
  return nodes;
}

std::vector<ShownModel> models_of(const Content& content) {
  std::vector<ShownModel> models;
  const auto add = [&](const fs::path& file, const std::string& scene, const std::shared_ptr<const Model>& model) {
    auto known = std::ranges::find(models, file, &ShownModel::file);
    if (known == models.end()) known = models.insert(known, ShownModel{file, {}});
    if (std::ranges::find(known->scenes, scene, &ShownModel::Scene::name) == known->scenes.end())
      known->scenes.push_back({scene, model});
  };
  const auto& object = content.config.installation.object;
  if (!content.eras) add(object.model, object.scene, content.model);
  if (content.eras)
    for (const auto& era : *content.eras) add(era.model_file, era.scene, era.model);
  return models;
}

struct ModelSize {
  std::size_t triangles = 0, texels = 0;
  int widest = 0;  // texture, texels a side
  std::uintmax_t bytes = 0;
  bool too_large() const { return triangles > kManyTriangles || widest > kLargeTexture || bytes > kLargeModelBytes; }
};

ModelSize size_of(const ShownModel& shown) {
  ModelSize size;
  std::error_code error;
  for (const auto& file : shown.first().files)
    if (const auto bytes = fs::file_size(file, error); !error) size.bytes += bytes;
  for (const auto& scene : shown.scenes) size.triangles = std::max(size.triangles, scene.model->triangle_count());
  for (const auto& texture : shown.first().textures) {
    size.texels += texture.pixels.elements().size();
    size.widest = std::max({size.widest, texture.pixels.width(), texture.pixels.height()});
  }
  return size;
}

// How large a pixel of the scene camera is on the nearest part of the model, in the model's units; empty: the camera does
// not see it.
std::optional<double> pixel_on(const Installation& installation, const ModelBounds& bounds, double& distance_m) {
  const Camera& camera = installation.scene;
  if (!camera.lens || camera.width < 2 || camera.height < 2) return std::nullopt;
  if (!sight_object(installation, bounds).in_picture()) return std::nullopt;
  const glm::dmat4 place = model_to_world(installation.object.placement);
  const glm::dvec3 lowest(bounds.lowest), highest(bounds.highest), eye(glm::inverse(place)[3]);
  const double away = glm::distance(eye, glm::clamp(eye, lowest, highest));
  distance_m = away * installation.object.placement.scale;
  const glm::dvec3 middle(place * glm::dvec4(0.5 * (lowest + highest), 1.0));
  auto pixel = camera.pixel_of(glm::normalize(middle));
  if (!pixel) return std::nullopt;
  pixel = glm::clamp(*pixel, glm::dvec2(0.0), glm::dvec2(camera.width - 2, camera.height - 2));
  const auto here = camera.direction_at(*pixel), beside = camera.direction_at(*pixel + glm::dvec2(1.0, 0.0)),
             below = camera.direction_at(*pixel + glm::dvec2(0.0, 1.0));
  if (!here || !beside || !below) return std::nullopt;
  return away * std::min(glm::distance(*here, *beside), glm::distance(*here, *below));
}

// The scenes under their names and numbers; the default one, which may be any of them, once more behind them.
std::vector<WrittenScene> scenes_to_write(const ShownModel& shown, const std::vector<Model>& models,
                                          std::size_t& first_shown) {
  std::vector<WrittenScene> written;
  const bool named = shown.scenes.size() > 1 || !shown.scenes.front().name.empty();
  if (named)
    for (const auto& name : shown.first().scenes) written.push_back({name, nullptr});
  for (std::size_t i = 0; i < shown.scenes.size(); ++i) {
    const auto& name = shown.scenes[i].name;
    auto to = std::ranges::find(written, name, &WrittenScene::name);
    if (name.empty()) {
      first_shown = written.size();
      written.push_back({"", &models[i]});
    } else if (to != written.end()) {
      to->model = &models[i];
    } else {
      written[static_cast<std::size_t>(std::stoi(name))].model = &models[i];
    }
  }
  return written;
}

// A model as it would be packed.
struct Candidate {
  ShownModel shown;  // as it is read back
  ModelSize size;
};

class ModelReducer {
 public:
  ModelReducer(const Content& content, const ShownModel& shown, fs::path file, double most_loss)
      : installation_(content.config.installation),
        visitor_(content.visitor.get()),
        shown_(shown),
        file_(std::move(file)),
        most_loss_(most_loss) {}

  // Empty: the model stays as it is, and line() says why.
  Result<std::optional<ShownModel>> reduce() {
    const ModelSize before = size_of(shown_);
    double distance_m = 0.0;
    for (const auto& scene : shown_.scenes) {
      const auto pixel = pixel_on(installation_, scene.model->bounds(), distance_m);
      if (!pixel) return stays("the scene camera does not see it, so nothing says how fine it must be");
      pixel_ = std::min(pixel_, *pixel);
    }
    auto context = open_headless_context();
    if (!context) return stays(fmt::format("what it would lose cannot be measured: {}", context.error().message));
    auto original = ReductionDrawings::draw(**context, installation_, models(shown_));
    if (!original) return fail(original.error());
    std::optional<ReductionLoss> least;
    for (const auto& coarseness : kCoarsenesses) {
      auto made = candidate(coarseness);
      if (!made) return fail(made.error());
      if (!gains(before, made->size)) continue;
      const auto drawn = ReductionDrawings::draw(**context, installation_, models(made->shown));
      if (!drawn) return fail(drawn.error());
      least = loss(*original, *drawn);
      if (least->worst_mean > most_loss_) continue;
      line_ = fmt::format(
          "{}: reduced to what the scene camera shows of it {:.2f} km away, where a pixel is {:.2g} m: {} -> {} "
          "triangles, "
          "textures of {} -> {} texels a side, {:.1f} -> {:.1f} MB; it loses {:.2f} of 255 in the mean over the "
          "building's "
          "{} pixels, {:.2f} under the worst sun, {:.0f} in the worst pixel",
          shown_.file.string(), 1e-3 * distance_m, pixel_ * installation_.object.placement.scale, before.triangles,
          made->size.triangles, before.widest, made->size.widest, megabytes(before), megabytes(made->size), least->mean,
          least->pixels, least->worst_mean, least->worst_pixel);
      return std::optional(std::move(made->shown));
    }
    if (!least) return stays("the scene camera shows all of it");
    return stays(fmt::format("reduced, it would lose {:.2f} of 255 (--most-loss {:g})", least->worst_mean, most_loss_));
  }

  const std::string& line() const { return line_; }

 private:
  std::optional<ShownModel> stays(const std::string& why) {
    const ModelSize size = size_of(shown_);
    line_ = fmt::format("{}: {} triangles, textures of {} texels a side, {:.1f} MB, packed as it is: {}",
                        shown_.file.string(), size.triangles, size.widest, megabytes(size), why);
    return std::nullopt;
  }

  static double megabytes(const ModelSize& size) { return 1e-6 * static_cast<double>(size.bytes); }

  static bool gains(const ModelSize& before, const ModelSize& after) {
    const auto fewer = [](std::size_t now, std::size_t then) {
      return static_cast<double>(now) < kWorthwhile * static_cast<double>(then);
    };
    return after.bytes < before.bytes &&
           (fewer(after.triangles, before.triangles) || fewer(after.texels, before.texels));
  }

  static std::vector<std::shared_ptr<const Model>> models(const ShownModel& shown) {
    std::vector<std::shared_ptr<const Model>> all;
    for (const auto& scene : shown.scenes) all.push_back(scene.model);
    return all;
  }

  // Written, and read as the kiosk reads it.
  Result<Candidate> candidate(const PixelCoarseness& coarseness) {
    std::vector<Model> scenes;
    for (const auto& scene : shown_.scenes) {
      scenes.push_back(*scene.model);
      scenes.back().nodes = nodes_of_stories(*scene.model, visitor_);
    }
    auto coarse =
        coarser(std::move(scenes), {coarseness.error * pixel_, coarseness.relief * pixel_, coarseness.texel * pixel_});
    if (!coarse) return fail(coarse.error());
    if (pictures_.empty() || pictures_texel_ != coarseness.texel) {
      auto pictures = texture_files(coarse->front().textures);
      if (!pictures) return fail(pictures.error());
      pictures_ = std::move(*pictures);
      pictures_texel_ = coarseness.texel;
    }
    std::size_t first_shown = 0;
    const auto written = scenes_to_write(shown_, *coarse, first_shown);
    const bool text = !is_binary();
    if (auto done = write_file(file_, gltf_of(written, first_shown, pictures_, text)); !done) return fail(done.error());
    Candidate made{{shown_.file, {}}, {}};
    for (const auto& scene : shown_.scenes) {
      auto read = read_gltf(file_, {}, scene.name);
      if (!read) return fail(read.error());
      // The original's notes are reported; what was written of it can be read whole.
      if (!read->notes.empty())
        return fail(FaultKind::io, "{}, reduced: {}", shown_.file.string(), read->notes.front());
      make_levels(*read);
      made.shown.scenes.push_back({scene.name, std::make_shared<const Model>(std::move(*read))});
    }
    made.size = size_of(made.shown);
    return made;
  }

  bool is_binary() const {
    const auto bytes = read_file(shown_.file);
    return bytes && bytes->size() > 4 && std::string(bytes->begin(), bytes->begin() + 4) == "glTF";
  }

  const Installation& installation_;
  const VisitorContent* visitor_;
  const ShownModel& shown_;
  fs::path file_;
  double most_loss_;
  double pixel_ = HUGE_VAL;
  std::vector<std::vector<std::uint8_t>> pictures_;
  double pictures_texel_ = 0.0;
  std::string line_;
};

// With that model in the place of the one of its name.
ContentPtr with_model(const Content& content, const ShownModel& reduced) {
  auto changed = std::make_shared<Content>(content);
  const auto put = [&](const fs::path& file, const std::string& scene, std::shared_ptr<const Model>& model) {
    if (file != reduced.file) return;
    const auto found = std::ranges::find(reduced.scenes, scene, &ShownModel::Scene::name);
    if (found != reduced.scenes.end()) model = found->model;
  };
  const auto& object = changed->config.installation.object;
  put(object.model, object.scene, changed->model);
  if (content.eras) {
    auto eras = *content.eras;
    for (auto& era : eras) put(era.model_file, era.scene, era.model);
    changed->eras = std::make_shared<const std::vector<EraContent>>(std::move(eras));
  }
  return changed;
}

}  // namespace

Result<ModelReduction> reduce_models(const ContentPtr& content, const fs::path& workplace, double most_loss) {
  ModelReduction reduction{content, {}, {}, {}};
  std::vector<fs::path> needed;  // by models that stay as they are
  for (const auto& shown : models_of(*content)) {
    const auto& files = shown.first().files;
    const auto file = workplace / fmt::format("{}-{}", reduction.instead.size(), shown.file.filename().string());
    ModelReducer reducer(*content, shown, file, most_loss);
    auto reduced = size_of(shown).too_large() ? reducer.reduce() : Result<std::optional<ShownModel>>(std::nullopt);
    if (!reduced) return fail(reduced.error());
    if (!reducer.line().empty()) reduction.lines.push_back(reducer.line());
    auto& where_to = *reduced ? reduction.left_out : needed;
    if (!files.empty()) where_to.insert(where_to.end(), files.begin() + 1, files.end());
    if (!*reduced) continue;
    reduction.instead[shown.file] = file;
    reduction.content = with_model(*reduction.content, **reduced);
  }
  std::erase_if(reduction.left_out,
                [&](const fs::path& file) { return std::ranges::find(needed, file) != needed.end(); });
  return reduction;
}

}  // namespace kasumi
