#include "report/report_config.hpp"

#include <algorithm>

#include <arpa/inet.h>
#include <unistd.h>

#include "base/files.hpp"
#include "report/web/web_request.hpp"

namespace kasumi::report {

namespace {

constexpr std::size_t kLongestSecret = 1000, kMostAddresses = 16;  // far above any real one: bounds what is read
constexpr std::size_t kMostTokens = 8;                             // each costs a hash for every guess

bool is_loopback(const std::string& address) {
  in_addr four{};
  if (::inet_pton(AF_INET, address.c_str(), &four) == 1) return (ntohl(four.s_addr) >> 24) == 127;
  return address == "::1";
}

bool is_address(const std::string& address) {
  in_addr four{};
  in6_addr six{};
  return ::inet_pton(AF_INET, address.c_str(), &four) == 1 || ::inet_pton(AF_INET6, address.c_str(), &six) == 1;
}

AccessToken read_token(const ConfigTable& table) {
  AccessToken token;
  token.name = table.text("name");
  token.hash = table.text("hash");
  token.until = table.optional_utc("until_utc");
  if (!token.hash.empty() && !is_usable_hash(token.hash))
    table.problem("hash", "a hash like \"$y$...\", as `kasumi-report token` prints it");
  return token;
}

HttpOptions read_http(const ConfigTable& table) {
  HttpOptions http;
  http.address = table.text("address", http.address);
  http.port = table.integer("port", {1, 65535}, http.port);
  http.names = table.texts("names");
  http.screen_picture = table.flag("screen_picture", http.screen_picture);
  for (const auto& token : table.tables("tokens")) http.tokens.push_back(read_token(token));
  if (http.tokens.size() > kMostTokens) table.problem("tokens", fmt::format("at most {} of them", kMostTokens));
  if (!is_address(http.address))
    table.problem("address", "a number like \"127.0.0.1\" or \"::1\"");
  else if (!is_loopback(http.address) && http.tokens.empty())
    table.problem("address", "127.0.0.1 or ::1, or [[http.tokens]], without which the whole network might read it");
  return http;
}

// A secret in a file of its own: one line, which is all of it.
std::string read_secret(const ConfigTable& table, std::string_view key) {
  const auto file = table.optional_file(key);
  std::error_code error;
  if (!file || !std::filesystem::is_regular_file(*file, error)) return {};
  auto text = read_text_file(*file, kSmallFile);
  if (!text) {
    table.problem(key, fmt::format("a file that can be read ({})", text.error().message));
    return {};
  }
  while (text->ends_with('\n') || text->ends_with('\r')) text->pop_back();
  const bool several = std::ranges::any_of(*text, [](char c) { return static_cast<unsigned char>(c) < 0x20; });
  if (text->empty() || text->size() > kLongestSecret || several) {
    table.problem(key, "a file of one line, the password");
    return {};
  }
  return *text;
}

// Letters, digits and lines of this machine's name.
std::string machine_name() {
  char name[256] = {};
  if (::gethostname(name, sizeof name - 1) != 0) return "kiosk";
  std::string plain;
  for (const char c : std::string_view(name))
    plain += std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '.' ? c : '_';
  return plain.empty() ? "kiosk" : plain;
}

// Machines that were made from one image have one name, but each an id of its own. A hash of it: it is not for others.
std::string machine_mark() {
  const auto id = read_text_file("/etc/machine-id", kSmallFile).value_or("");
  std::uint32_t hash = 0x811c9dc5U;  // FNV-1a
  for (const char c : "kasumi" + id) hash = (hash ^ static_cast<unsigned char>(c)) * 0x01000193U;
  return fmt::format("{:08x}", hash);
}

bool is_one_word(std::string_view text) {
  return !text.empty() &&
         std::ranges::all_of(text, [](char c) { return static_cast<unsigned char>(c) > 0x20 && c != 0x7f; });
}

MqttOptions read_mqtt(const ConfigTable& table) {
  MqttOptions mqtt;
  mqtt.host = table.text("host");
  if (!mqtt.host.empty() && !is_one_word(mqtt.host)) table.problem("host", "a name or an address");
  mqtt.tls = table.flag("tls", mqtt.tls);
  mqtt.port = table.integer("port", {1, 65535}, mqtt.tls ? 8883 : 1883);
  if (const auto file = table.optional_file("ca_file")) mqtt.ca_file = file->string();
  if (const auto file = table.optional_file("cert_file")) mqtt.cert_file = file->string();
  if (const auto file = table.optional_file("key_file")) mqtt.key_file = file->string();
  if (mqtt.cert_file.empty() != mqtt.key_file.empty())
    table.problem(mqtt.key_file.empty() ? "key_file" : "cert_file", "both cert_file and key_file, or neither");
  else if (!mqtt.cert_file.empty() && !mqtt.tls)
    table.problem("tls", "true, without which a certificate is of no use");
  mqtt.user = table.text("user", std::string());
  mqtt.password = read_secret(table, "password_file");
  if (table.has("password_file") && mqtt.user.empty()) table.problem("user", "the user whose password it is");
  mqtt.topic = table.text("topic", fmt::format("kasumi/{}-{}", machine_name(), machine_mark()));
  if (!is_topic(mqtt.topic)) table.problem("topic", "words with / between them, without +, # and $ at their beginning");
  mqtt.discovery = table.text("discovery", mqtt.discovery);
  if (!mqtt.discovery.empty() && !is_topic(mqtt.discovery))
    table.problem("discovery", "Home Assistant's prefix, such as \"homeassistant\", or \"\"");
  mqtt.every = std::chrono::seconds(table.integer("every_s", {1, 3600}, 60));
  return mqtt;
}

MailOptions read_mail(const ConfigTable& table) {
  MailOptions mail;
  mail.to = table.texts("to");
  if (mail.to.empty() || mail.to.size() > kMostAddresses || !std::ranges::all_of(mail.to, is_mail_address))
    table.problem("to", fmt::format("1 to {} addresses like \"me@example.org\"", kMostAddresses));
  mail.from = table.text("from", std::string());
  if (!mail.from.empty() && !is_mail_address(mail.from)) table.problem("from", "an address like \"me@example.org\"");
  if (table.has("command")) mail.command = table.texts("command");
  if (mail.command.empty() || !mail.command[0].starts_with('/'))
    table.problem("command",
                  "a program's whole name and its arguments, such as [\"/usr/sbin/sendmail\", \"-i\", \"-t\"]");
  mail.pause = std::chrono::minutes(table.integer("pause_min", {1, 1440}, 15));
  mail.memory_file = table.text("memory_file", mail.memory_file);
  return mail;
}

SignOfLifeOptions read_sign_of_life(const ConfigTable& table) {
  SignOfLifeOptions sign;
  sign.url = table.text("url");
  if (!sign.url.empty() && !is_web_address(sign.url))
    table.problem("url", "an address like \"https://example.org/ping\"");
  sign.every = std::chrono::minutes(table.integer("every_min", {1, 1440}, 5));
  if (const auto file = table.optional_file("ca_file")) sign.ca_file = file->string();
  return sign;
}

PullOptions read_pull(const ConfigTable& table) {
  PullOptions pull;
  pull.url = table.text("url");
  if (!pull.url.empty() && !(is_web_address(pull.url) && pull.url.starts_with("https://")))
    table.problem("url", "an address like \"https://example.org/hill.kasumi\"");
  pull.every = std::chrono::minutes(table.integer("every_min", {1, 1440}, 15));
  if (const auto file = table.optional_file("ca_file")) pull.ca_file = file->string();
  pull.folder = table.text("folder", pull.folder.string());
  if (!pull.folder.is_absolute()) table.problem("folder", "a folder's whole name");
  return pull;
}

}  // namespace

ReportConfig read_report_config(const ConfigTable& root) {
  ReportConfig config;
  const auto kiosk = root.optional_table("kiosk").value_or(*ConfigTable::parse("", root.path()));
  config.status = kiosk.text("status", std::string("/run/kasumi/status.json"));
  config.state = kiosk.text("state", std::string("/var/lib/kasumi"));
  config.name = kiosk.text("name", std::string("Kasumi"));
  const auto language = parse_language(kiosk.text("language", std::string("en")));
  if (language)
    config.language = *language;
  else
    kiosk.problem("language", language.error().message);
  if (const auto http = root.optional_table("http")) config.http = read_http(*http);
  if (const auto textfile = root.optional_table("textfile")) {
    config.textfile = TextfileOptions{textfile->text("file")};
    if (config.textfile->file.extension() != ".prom")
      textfile->problem("file", "a file that ends in .prom, which is what node_exporter reads");
  }
  if (const auto mqtt = root.optional_table("mqtt")) config.mqtt = read_mqtt(*mqtt);
  if (const auto mail = root.optional_table("mail")) config.mail = read_mail(*mail);
  if (const auto sign = root.optional_table("sign_of_life")) config.sign_of_life = read_sign_of_life(*sign);
  if (const auto pull = root.optional_table("content")) config.content = read_pull(*pull);
  return config;
}

Result<ReportConfig> read_report_config(const std::filesystem::path& file) {
  const auto root = ConfigTable::read_file(file);
  if (!root) return fail(root.error());
  auto config = read_report_config(*root);
  if (auto whole = root->finish(); !whole) return fail(whole.error());
  return config;
}

}  // namespace kasumi::report
