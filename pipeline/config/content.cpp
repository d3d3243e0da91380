#include "pipeline/config/content.hpp"

#include <algorithm>
#include <cmath>
#include <new>

#include "base/files.hpp"
#include "base/picture_header.hpp"
#include "gles/model/mip_levels.hpp"
#include "pipeline/files/photograph_file.hpp"

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
                                  const Model& model) {
  std::vector<std::filesystem::path> paths{config_file};
  for (const auto& [key, path] : root.files_asked()) paths.push_back(path);
  paths.insert(paths.end(), model.files.begin(), model.files.end());
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

// A missing file is already reported by the reader of its key.
Result<ContentPtr> read_all(const std::filesystem::path& config_file, const std::filesystem::path& copies) {
  const auto root = copies.empty() ? ConfigTable::read_file(config_file) : ConfigTable::read_copy(config_file, copies);
  if (!root) return fail(root.error());
  auto content = std::make_shared<Content>();
  content->config = read_run_config(*root);

  if (const auto& file = content->config.installation.object.model; is_there(file)) {
    if (auto model = read_gltf(file, {}, content->config.installation.object.scene))
      content->model = std::move(*model);
    else
      root->table("object").problem("model", fmt::format("a model that can be read:\n{}", model.error().message));
  }
  if (const auto& file = content->config.still.picture; file && is_there(*file)) {
    if (auto still = read_still(*file))
      content->still = std::move(*still);
    else
      root->table("still").problem("picture", fmt::format("a picture: {}", still.error().message));
  }
  if (auto whole = root->finish(); !whole)
    return fail(Fault{disk_failed(*root) ? FaultKind::io : FaultKind::bad_input, whole.error().message});
  make_levels(content->model);
  content->files = files_of(config_file, *root, content->model);
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

}  // namespace kasumi
