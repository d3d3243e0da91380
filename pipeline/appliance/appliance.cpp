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
      scene_(content, services.devices, services.clock, mailboxes_),
      sky_(content, services.devices, services.clock, services.time, mailboxes_, std::move(sky)),
      render_(content, services.devices, services.clock, services.notifier, mailboxes_),
      status_(content, std::move(status), services.clock, services.notifier, mailboxes_),
      check_(content, config_file_, services.clock, mailboxes_),
      visibility_(std::move(content), services.clock, mailboxes_) {}

void Appliance::reload() {
  services_.notifier.reloading();
  auto content = read_content(config_file_);
  ReloadStatus status{services_.clock.utc(), {}};
  if (content) {
    spdlog::info("{}: reloaded", config_file_.string());
    for (Mailbox* mailbox : mailboxes_.all()) mailbox->content.put(*content);
  } else {
    status.problems = lines_of(content.error().message);
    spdlog::error("the new content is invalid, keeping the old content:");
    for (const auto& problem : status.problems) spdlog::error("  {}", problem);
  }
  mailboxes_.status->reload.put(std::move(status));
  mailboxes_.render.bell.ring();
  services_.notifier.ready();
}

}  // namespace kasumi
