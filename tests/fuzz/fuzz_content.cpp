// A whole kiosk: kasumi.toml and the files it names, as one input (pack.hpp). What is accepted must be usable.
#include "gles/model/model.hpp"
#include "pipeline/site/config/content.hpp"
#include "tests/fuzz/pack.hpp"
#include "tests/fuzz/scratch.hpp"

void kasumi::try_input(std::span<const std::uint8_t> input) {
  static const Scratch scratch;
  unpack(input, scratch);
  const auto content = read_content(scratch.folder() / "kasumi.toml");
  expect_value_or_sentence(content);
  if (!content) return;
  for (const Camera* camera : {&(*content)->config.installation.sky, &(*content)->config.installation.scene}) {
    const auto direction = camera->direction_at({0.5 * camera->width, 0.5 * camera->height});
    if (direction) camera->pixel_of(*direction);
  }
  if ((*content)->still && (*content)->still->empty()) std::abort();
}
