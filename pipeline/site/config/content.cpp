#include "pipeline/site/config/content.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <new>
#include <utility>

#include "base/files.hpp"
#include "base/outside/abandonable.hpp"
#include "base/picture_header.hpp"
#include "gles/model/mip_levels.hpp"
#include "pipeline/site/files/photograph_file.hpp"

namespace kasumi {

namespace {

bool is_there(const std::filesystem::path& file) {
  std::error_code error;
  return !file.empty() && std::filesystem::is_regular_file(file, error);
}

Image<Rgba8> with_opacity(const Photograph& photograph) {
  const auto picture = to_rgb8(photograph);
  Image<Rgba8> made(picture.width(), picture.height());
  const auto& opacity = photograph.opacity.elements();
  for (std::size_t i = 0; i < made.elements().size(); ++i)
    made.elements()[i] = Rgba8(
        picture.elements()[i],
        opacity.empty() ? 255 : static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(opacity[i], 0.0F, 1.0F))));
  return made;
}

std::vector<ContentFile> files_of(const std::filesystem::path& config_file, const ConfigTable& root,
                                  const std::vector<EraContent>& eras) {
  std::vector<std::filesystem::path> paths{config_file};
  for (const auto& [key, path] : root.files_asked()) paths.push_back(path);
  for (const auto& era : eras) paths.insert(paths.end(), era.model->files.begin(), era.model->files.end());
  std::vector<ContentFile> files;
  for (const auto& path : paths)
    if (auto file = content_file(path); file && std::ranges::find(files, *file) == files.end())
      files.push_back(std::move(*file));
  return files;
}

// Before it is decoded, which takes many times what the display will show.
Result<> check_still(const std::filesystem::path& file) {
  const auto bytes = read_file(file);
  if (!bytes) return fail(bytes.error());
  const auto header = picture_header(*bytes);
  if (!header) return {};  // read_photograph() says so
  if (auto bounded = check_size(*header, kStillLimits); !bounded)
    return fail(FaultKind::bad_input, "{}: {}", file.string(), bounded.error().message);
  return {};
}

// What the disk did may pass, and no person has to correct it.
bool disk_failed(const ConfigTable& root) {
  return std::ranges::any_of(root.files_asked(), [](const auto& asked) {
    const auto read = read_file(asked.second);
    return !read && read.error().kind == FaultKind::io;
  });
}

// What is read once, however many eras name it.
struct ShownFiles {
  std::map<std::pair<std::filesystem::path, std::string>, std::shared_ptr<const Model>> models;
  std::map<std::filesystem::path, std::shared_ptr<const Image<Rgba8>>> stills;
};

// `problem` is called for unreadable files; a missing file is already reported by the reader of its key.
template <class Problem>
std::shared_ptr<const Model> model_of(const std::filesystem::path& file, const std::string& scene, ShownFiles& files,
                                      Problem problem) {
  auto& known = files.models[{file, scene}];
  if (known) return known;
  auto made = std::make_shared<Model>();
  if (is_there(file)) {
    if (auto model = read_gltf(file, {}, scene)) {
      *made = std::move(*model);
      make_levels(*made);
    } else {
      problem(fmt::format("a model that can be read:\n{}", model.error().message));
    }
  }
  return known = made;
}

template <class Problem>
std::shared_ptr<const Image<Rgba8>> still_of(const std::filesystem::path& file, ShownFiles& files, Problem problem) {
  if (!is_there(file)) return nullptr;
  auto& known = files.stills[file];
  if (known) return known;
  auto still = read_still(file);
  if (still) return known = std::make_shared<const Image<Rgba8>>(std::move(*still));
  problem(fmt::format("a picture: {}", still.error().message));
  return nullptr;
}

// `era`: null: what [object] and [still] say, else what its table says instead of them.
EraContent read_shown(const RunConfig& config, const Era* era, const ConfigTable& root, const ConfigTable& table,
                      ShownFiles& files) {
  const auto& object = config.installation.object;
  const bool own_model = era && (era->model || era->scene), own_picture = era && era->picture;
  EraContent made{object.model, object.scene, config.still, nullptr, nullptr};
  if (era && era->model) {
    made.model_file = *era->model;
    made.scene.clear();  // [object]'s is of another model
  }
  if (era && era->scene) made.scene = *era->scene;
  if (own_picture) made.still_options.picture = era->picture;
  if (era && era->caption) made.still_options.caption = *era->caption;
  made.model = model_of(made.model_file, made.scene, files, [&](const std::string& expected) {
    if (!own_model) return root.table("object").problem("model", expected);
    table.problem(era->scene ? "scene" : "model", expected);
  });
  if (made.still_options.picture)
    made.still = still_of(*made.still_options.picture, files, [&](const std::string& expected) {
      (own_picture ? table : root.table("still")).problem("picture", expected);
    });
  return made;
}

std::vector<ModelInEra> in_eras(const std::vector<Era>& eras, const std::vector<EraContent>& shown) {
  std::vector<ModelInEra> models;
  for (std::size_t i = 0; i < shown.size(); ++i)
    models.push_back({i < eras.size() ? eras[i].name : std::string(), shown[i].model.get()});
  return models;
}

std::shared_ptr<const VisitorContent> read_visitor(const RunConfig& config, const std::vector<EraContent>& eras,
                                                   const ConfigTable& root) {
  if (!config.visitor_content || !is_there(*config.visitor_content)) return nullptr;
  auto visitor = read_visitor_content(*config.visitor_content, in_eras(config.eras, eras));
  if (visitor) return std::make_shared<const VisitorContent>(std::move(*visitor));
  root.problem("content", fmt::format("content that can be read:\n{}", visitor.error().message));
  return nullptr;
}

void show(Content& content, const EraContent& era) {
  content.config.installation.object.model = era.model_file;
  content.config.installation.object.scene = era.scene;
  content.config.still = era.still_options;
  content.model = era.model;
  content.still = era.still;
}

ContentPtr in_era(const ContentPtr& content, std::size_t era) {
  if (!content->eras || era == content->era) return content;
  auto changed = std::make_shared<Content>(*content);
  changed->era = era;
  show(*changed, (*content->eras)[era]);
  return changed;
}

Result<ContentPtr> read_all(const std::filesystem::path& config_file, const std::filesystem::path& copies) {
  const auto root = copies.empty() ? ConfigTable::read_file(config_file) : ConfigTable::read_copy(config_file, copies);
  if (!root) return fail(root.error());
  auto content = std::make_shared<Content>();
  content->config = read_run_config(*root);

  ShownFiles files;
  std::vector<EraContent> eras;
  if (const auto& listed = content->config.eras; listed.empty()) {
    eras.push_back(read_shown(content->config, nullptr, *root, *root, files));
  } else {
    const auto tables = root->tables("era");
    for (std::size_t i = 0; i < listed.size(); ++i)
      eras.push_back(read_shown(content->config, &listed[i], *root, tables[i], files));
  }
  content->visitor = read_visitor(content->config, eras, *root);
  if (auto whole = root->finish(); !whole)
    return fail(Fault{disk_failed(*root) ? FaultKind::io : FaultKind::bad_input, whole.error().message});
  content->files = files_of(config_file, *root, eras);
  if (!content->config.eras.empty()) content->eras = std::make_shared<const std::vector<EraContent>>(eras);
  show(*content, eras.front());
  return content;
}

}  // namespace

std::optional<ContentFile> content_file(const std::filesystem::path& path) {
  std::error_code error;
  ContentFile file{path, std::filesystem::file_size(path, error)};
  if (error) return std::nullopt;
  const auto changed = std::filesystem::last_write_time(path, error);
  if (error) return std::nullopt;
  file.changed_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(changed.time_since_epoch()).count();
  return file;
}

Result<Image<Rgba8>> read_still(const std::filesystem::path& file) {
  if (auto bounded = check_still(file); !bounded) return fail(bounded.error());
  std::string damage;  // half a still picture is better than none
  const auto photograph = read_photograph(file, &damage);
  if (!photograph) return fail(photograph.error());
  return with_opacity(*photograph);
}

// Content comes from outside and may be of any size: a library that gives up by an exception must not end the picture.
Result<ContentPtr> read_content(const std::filesystem::path& config_file, const std::filesystem::path& copies) try {
  return read_all(config_file, copies);
} catch (const std::bad_alloc&) {
  return fail(FaultKind::io, "{}: not enough memory for what it names", config_file.string());
} catch (const std::exception& thrown) {
  return fail(FaultKind::bad_input, "{}: cannot be read: {}", config_file.string(), thrown.what());
}

Result<ContentPtr> read_content_within(std::chrono::nanoseconds longest, const std::filesystem::path& config_file) {
  auto content = within<Result<ContentPtr>>(longest, [config_file] { return read_content(config_file); });
  if (content) return std::move(*content);
  return fail(FaultKind::io, "{}: reading it and what it names takes longer than {:.0f} s: does the disk answer?",
              config_file.string(), std::chrono::duration<double>(longest).count());
}

ContentPtr in_its_era(const ContentPtr& content, Utc now, std::size_t further) {
  if (!content->eras) return content;
  const auto& config = content->config;
  const auto of_the_day = era_at(config.eras, config.opening.time_zone, now);
  if (!of_the_day) return in_era(content, content->era);
  return in_era(content, (*of_the_day + further) % content->eras->size());
}

std::vector<ModelInEra> shown_models(const Content& content) {
  return content.eras ? in_eras(content.config.eras, *content.eras) : std::vector{ModelInEra{"", content.model.get()}};
}

std::vector<ContentPtr> all_eras(const ContentPtr& content) {
  if (!content->eras) return {content};
  std::vector<ContentPtr> all;
  for (std::size_t era = 0; era < content->eras->size(); ++era) all.push_back(in_era(content, era));
  return all;
}

std::vector<std::string> model_notes(const Content& content) {
  std::vector<std::string> notes;
  const auto add = [&](const Model& model) {
    for (const auto& note : model.notes)
      if (std::ranges::find(notes, note) == notes.end()) notes.push_back(note);
  };
  add(*content.model);
  if (content.eras)
    for (const auto& era : *content.eras) add(*era.model);
  return notes;
}

std::string era_name(const Content& content) {
  return content.eras ? content.config.eras[content.era].name : std::string();
}

}  // namespace kasumi
