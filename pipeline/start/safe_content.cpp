#include "pipeline/start/safe_content.hpp"

#include <spdlog/spdlog.h>

namespace kasumi {

namespace {

// Any screen in its own mode.
void forget_choices(DisplayOptions& display) {
  auto* kms = std::get_if<KmsDisplayOptions>(&display);
  if (!kms) return;
  KmsDisplayOptions any;
  any.preferred_instead = true;
  any.atomic = kms->atomic;
  *kms = any;
}

}  // namespace

ContentPtr read_safe_content(const std::filesystem::path& config_file, StartMode mode) {
  auto content = std::make_shared<Content>();
  auto& config = content->config;
  if (const auto root = ConfigTable::read_file(config_file))
    read_screen(*root, config);
  else
    spdlog::warn("{}", root.error().message);
  if (mode == StartMode::plain) {
    forget_choices(config.display);
    config.messages.font_file.reset();
    return content;
  }
  if (!config.still.picture) return content;
  if (auto still = read_still(*config.still.picture))
    content->still = std::make_shared<const Image<Rgba8>>(std::move(*still));
  else
    spdlog::warn("{}", still.error().message);
  return content;
}

}  // namespace kasumi
