#include "report/report_config.hpp"

#include <arpa/inet.h>

namespace kasumi::report {

namespace {

constexpr std::size_t kMostTokens = 8;  // each costs a hash when a guess is looked at

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

TokenOptions read_token(const ConfigTable& table) {
  TokenOptions token;
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
  for (const auto& token : table.tables("tokens")) http.tokens.push_back(read_token(token));
  if (http.tokens.size() > kMostTokens) table.problem("tokens", fmt::format("at most {} of them", kMostTokens));
  if (!is_address(http.address))
    table.problem("address", "a number like \"127.0.0.1\" or \"::1\"");
  else if (!is_loopback(http.address) && http.tokens.empty())
    table.problem("address", "127.0.0.1 or ::1, or [[http.tokens]], without which the whole network might read it");
  return http;
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
