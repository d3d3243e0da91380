// report.toml: what is reported, and to which recipients.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/table/config_table.hpp"
#include "base/words/language.hpp"
#include "report/channels/mail_text.hpp"
#include "report/channels/mqtt_channel.hpp"
#include "report/channels/sign_of_life.hpp"
#include "report/page/tokens.hpp"
#include "report/web/content_pull.hpp"

namespace kasumi::report {

struct HttpOptions {
  std::string address = "127.0.0.1";
  int port = 8750;
  std::vector<std::string> names;   // of hosts by which peers may call it; numbers and localhost always
  std::vector<AccessToken> tokens;  // empty: readable by all that reach it
  bool screen_picture = false;      // they may ask for a blurred picture of the screen
};

struct TextfileOptions {
  std::filesystem::path file;
};

struct ReportConfig {
  std::filesystem::path status;  // the appliance's
  std::filesystem::path state;   // its folder, whose disk is watched
  std::string name;              // of the kiosk
  Language language = Language::english;
  std::optional<HttpOptions> http;
  std::optional<TextfileOptions> textfile;
  std::optional<MqttOptions> mqtt;
  std::optional<MailOptions> mail;
  std::optional<SignOfLifeOptions> sign_of_life;
  std::optional<PullOptions> content;
};

// Errors (bad_input): all problems at once, with file, key, value and what was expected.
Result<ReportConfig> read_report_config(const std::filesystem::path& file);
ReportConfig read_report_config(const ConfigTable& root);

}  // namespace kasumi::report
