#include "pipeline/config/content.hpp"

#include <algorithm>
#include <cmath>

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

}  // namespace

// A missing file is already reported by the reader of its key.
Result<ContentPtr> read_content(const std::filesystem::path& config_file) {
  const auto root = ConfigTable::read_file(config_file);
  if (!root) return fail(FaultKind::bad_input, "{}", root.error().message);
  auto content = std::make_shared<Content>();
  content->config = read_run_config(*root);

  if (const auto& file = content->config.installation.object.model; is_there(file)) {
    if (auto model = read_gltf(file, {}, content->config.installation.object.scene))
      content->model = std::move(*model);
    else
      root->table("object").problem("model", fmt::format("a model that can be read:\n{}", model.error().message));
  }
  if (const auto& file = content->config.still.picture; file && is_there(*file)) {
    if (const auto photograph = read_photograph(*file))
      content->still = with_opacity(*photograph);
    else
      root->table("still").problem("picture", fmt::format("a picture: {}", photograph.error().message));
  }
  if (auto whole = root->finish(); !whole) return fail(whole.error());
  return content;
}

}  // namespace kasumi
