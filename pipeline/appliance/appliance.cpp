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

Appliance::Appliance(std::filesystem::path config_file, ContentPtr content, const ApplianceServices& services,
                     StatusOptions status, SkyWatchOptions sky)
    : config_file_(std::move(config_file)),
      services_(services),
      scene_(content, services.devices, services.clock, exchange_),
      sky_(content, services.devices, services.clock, services.time, exchange_, std::move(sky)),
      render_(content, services.devices, services.clock, services.notifier, exchange_),
      status_(content, std::move(status), services.clock, services.notifier, exchange_),
      check_(content, config_file_, services.clock, exchange_),
      visibility_(std::move(content), services.clock, exchange_) {}

void Appliance::reload() {
  services_.notifier.reloading();
  auto content = read_content(config_file_);
  ReloadNews news{services_.clock.utc(), {}};
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
  services_.notifier.ready();
}

}  // namespace kasumi
