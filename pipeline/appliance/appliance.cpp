#include "pipeline/appliance/appliance.hpp"

#include <sstream>

#include <spdlog/spdlog.h>

namespace kasumi {

namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

}  // namespace

Appliance::Appliance(std::filesystem::path config_file, ContentPtr content, const Ground& ground, StatusOptions status,
                     SkyWatchOptions sky)
    : config_file_(std::move(config_file)),
      ground_(ground),
      scene_(content, ground.devices, ground.clock, exchange_),
      sky_(content, ground.devices, ground.clock, ground.time, exchange_, std::move(sky)),
      render_(content, ground.devices, ground.clock, ground.notifier, exchange_),
      status_(content, std::move(status), ground.clock, ground.notifier, exchange_),
      check_(content, config_file_, ground.clock, exchange_),
      visibility_(std::move(content), ground.clock, exchange_) {}

void Appliance::reload() {
  ground_.notifier.reloading();
  auto content = read_content(config_file_);
  ReloadNews news{ground_.clock.utc(), {}};
  if (content) {
    spdlog::info("{}: taken in anew", config_file_.string());
    for (Mail* mail : exchange_.mails()) mail->content.put(*content);
  } else {
    news.problems = lines_of(content.error().message);
    spdlog::error("the new content is refused, the old one stays:");
    for (const auto& problem : news.problems) spdlog::error("  {}", problem);
  }
  exchange_.status->reload.put(std::move(news));
  exchange_.render.bell.ring();
  ground_.notifier.ready();
}

}  // namespace kasumi
