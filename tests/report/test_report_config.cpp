// report.toml: what is accepted, and how what is not is told.
#include <gmock/gmock.h>

#include <regex>

#include "base/files.hpp"
#include "report/report_config.hpp"
#include "tests/places.hpp"
#include "tests/report/told.hpp"

namespace kasumi::report {
namespace {

using testing::HasSubstr;

Result<ReportConfig> read(const std::string& text) {
  const auto root = ConfigTable::parse(text, "report.toml").value();
  auto config = read_report_config(root);
  if (auto whole = root.finish(); !whole) return fail(whole.error());
  return config;
}

std::string example() {
  return read_text_file(source_folder() / "systemd/report.toml").value();
}

// With every key that has a default spelled out, and every optional one in use.
std::string everything(std::string text) {
  text = std::regex_replace(text, std::regex(R"((^|\n)#([a-z0-9_]+ = ))"), "$1$2");
  return std::regex_replace(text, std::regex(R"((^|\n)# ((?:\[\[?[a-z_.]+\]\]?)|(?:[a-z0-9_]+ = )))"), "$1$2");
}

TEST(ReportConfigs, TheExampleOpensNothing) {
  const auto config = read(example());
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_FALSE(config->http || config->textfile);
}

TEST(ReportConfigs, TheExampleSpelledOutIsAcceptedAndItsDefaultsAreTrue) {
  ASSERT_NE(everything(example()), example());
  const auto config = read(everything(example()));
  ASSERT_TRUE(config) << config.error().message;
  const HttpOptions plain;
  ASSERT_TRUE(config->http && config->textfile);
  EXPECT_EQ(config->http->address, plain.address);
  EXPECT_EQ(config->http->port, plain.port);
  EXPECT_EQ(config->status, read("")->status);
  EXPECT_EQ(config->state, read("")->state);
}

TEST(ReportConfigs, EveryKeyThatIsReadIsInTheExample) {
  const auto root = ConfigTable::parse(everything(example()), "report.toml").value();
  read_report_config(root);
  for (const auto& key : root.keys_asked()) {
    const auto last = key.substr(key.rfind('.') + 1);
    EXPECT_TRUE(std::regex_search(example(), std::regex("(\\n(# |#)?" + last + " = )|(\\[[a-z_.]*" + last + "\\])")))
        << key;
  }
}

TEST(ReportConfigs, AllProblemsAreToldAtOnce) {
  const auto config = read(
      "[kiosk]\nlanguage = \"xx\"\n[http]\naddress = \"everywhere\"\nport = 99999\nprot = 1\n"
      "[[http.tokens]]\nname = \"me\"\nhash = \"secret\"\n[textfile]\nfile = \"kasumi.txt\"\n");
  ASSERT_FALSE(config);
  EXPECT_EQ(config.error().kind, FaultKind::bad_input);
  for (const auto* part : {"kiosk.language", "http.address", "http.port", "http.prot", "hash", "textfile.file"})
    EXPECT_THAT(config.error().message, HasSubstr(part));
}

TEST(ReportConfigs, TheWholeNetworkMayOnlyReadWithAToken) {
  for (const auto* address : {"0.0.0.0", "::", "192.168.1.2"})
    EXPECT_FALSE(read(fmt::format("[http]\naddress = \"{}\"\n", address))) << address;
  const auto made = new_token().value();
  EXPECT_TRUE(
      read(fmt::format("[http]\naddress = \"0.0.0.0\"\n[[http.tokens]]\nname = \"me\"\nhash = \"{}\"\n", made.hash)));
  for (const auto* address : {"127.0.0.1", "127.0.0.53", "::1"})
    EXPECT_TRUE(read(fmt::format("[http]\naddress = \"{}\"\n", address))) << address;
}

}  // namespace
}  // namespace kasumi::report
