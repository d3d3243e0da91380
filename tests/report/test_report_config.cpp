// report.toml: what is accepted, and how what is not is told.
#include <gmock/gmock.h>

#include <regex>

#include "base/files.hpp"
#include "report/report_config.hpp"
#include "tests/places.hpp"
#include "tests/report/running_reporter.hpp"

namespace kasumi::report {
namespace {

using testing::HasSubstr;

Result<ReportConfig> read(const std::string& text, const std::filesystem::path& folder = {}) {
  const auto root = ConfigTable::parse(text, folder / "report.toml").value();
  auto config = read_report_config(root);
  if (auto whole = root.finish(); !whole) return fail(whole.error());
  return config;
}

std::string example() {
  return read_text_file(source_folder() / "systemd/report.toml").value();
}

// With every key that has a default spelled out, and every optional one in use. Files lie beside it.
std::string everything(std::string text) {
  text = std::regex_replace(text, std::regex(R"((^|\n)#([a-z0-9_]+ = ))"), "$1$2");
  text = std::regex_replace(text, std::regex("/etc/kasumi/"), "");
  return std::regex_replace(text, std::regex(R"((^|\n)# ((?:\[\[?[a-z_.]+\]\]?)|(?:[a-z0-9_]+ = )))"), "$1$2");
}

TEST(ReportConfigs, TheExampleOpensNothing) {
  const auto config = read(example());
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_FALSE(config->http || config->textfile || config->mqtt || config->mail || config->sign_of_life ||
               config->content);
}

TEST(ReportConfigs, TheExampleSpelledOutIsAcceptedAndItsDefaultsAreTrue) {
  ASSERT_NE(everything(example()), example());
  const auto folder = report_folder("example");
  ASSERT_TRUE(write_text_file(folder / "mqtt-password", "secret\n"));
  for (const auto* file : {"broker-ca.pem", "mqtt-client.pem", "mqtt-client.key"})
    ASSERT_TRUE(write_text_file(folder / file, ""));
  const auto config = read(everything(example()), folder);
  ASSERT_TRUE(config) << config.error().message;
  const HttpOptions plain;
  ASSERT_TRUE(config->http && config->textfile && config->mqtt && config->mail && config->sign_of_life);
  EXPECT_EQ(config->http->address, plain.address);
  EXPECT_EQ(config->http->port, plain.port);
  EXPECT_EQ(config->http->screen_picture, plain.screen_picture);
  EXPECT_FALSE(plain.screen_picture) << "off unless somebody wants it";
  const auto mqtt = read("[mqtt]\nhost = \"x\"\n")->mqtt;
  EXPECT_EQ(config->mqtt->port, mqtt->port);
  EXPECT_EQ(config->mqtt->tls, mqtt->tls);
  EXPECT_EQ(config->mqtt->discovery, mqtt->discovery);
  EXPECT_EQ(config->mqtt->every, mqtt->every);
  EXPECT_EQ(config->mqtt->password, "secret");
  const auto mail = read("[mail]\nto = [\"me@example.org\"]\n")->mail;
  EXPECT_EQ(config->mail->command, mail->command);
  EXPECT_EQ(config->mail->pause, mail->pause);
  EXPECT_EQ(config->mail->memory_file, mail->memory_file);
  EXPECT_EQ(config->sign_of_life->every, read("[sign_of_life]\nurl = \"https://x\"\n")->sign_of_life->every);
  const auto content = read("[content]\nurl = \"https://x/y.kasumi\"\n")->content;
  ASSERT_TRUE(config->content && content);
  EXPECT_EQ(config->content->every, content->every);
  EXPECT_EQ(config->content->folder, content->folder);
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

TEST(ReportConfigs, AnMqttPasswordIsOneLineOfAFile) {
  const auto folder = report_folder("password");
  const auto with = [&](const std::string& text) {
    EXPECT_TRUE(write_text_file(folder / "password", text));
    return read("[mqtt]\nhost = \"broker\"\nuser = \"hill\"\npassword_file = \"password\"\n", folder);
  };
  EXPECT_EQ(with("a b \n")->mqtt->password, "a b ");
  for (const auto& bad : {std::string(), std::string("\n"), std::string("a\nb\n"), std::string(2000, 'x')}) {
    const auto config = with(bad);
    ASSERT_FALSE(config);
    EXPECT_THAT(config.error().message, HasSubstr("mqtt.password_file"));
    EXPECT_THAT(config.error().message, testing::Not(HasSubstr("a\nb")));
  }
  // Not in the configuration itself, which is copied and sent about.
  EXPECT_THAT(read("[mqtt]\nhost = \"broker\"\npassword = \"x\"\n").error().message, HasSubstr("mqtt.password"));
  EXPECT_THAT(read("[mqtt]\nhost = \"a b\"\ntopic = \"#\"\ndiscovery = \"+\"\n").error().message,
              testing::AllOf(HasSubstr("mqtt.host"), HasSubstr("mqtt.topic"), HasSubstr("mqtt.discovery")));
}

TEST(ReportConfigs, MailAndSignOfLifeGoWhereTheyCan) {
  const auto config = read(
      "[mail]\nto = [\"me\"]\nfrom = \"a@b\\nBcc: c@d\"\ncommand = [\"sendmail\"]\npause_min = 0\n"
      "[sign_of_life]\nurl = \"file:///etc/passwd\"\nevery_min = 0\n");
  ASSERT_FALSE(config);
  for (const auto* part :
       {"mail.to", "mail.from", "mail.command", "mail.pause_min", "sign_of_life.url", "sign_of_life.every_min"})
    EXPECT_THAT(config.error().message, HasSubstr(part));
  EXPECT_FALSE(read("[mail]\n"));
  EXPECT_FALSE(read("[sign_of_life]\n"));
}

TEST(ReportConfigs, ContentComesOverTlsAlone) {
  for (const auto* bad : {"http://example.org/hill.kasumi", "file:///hill.kasumi", "https://", "ftp://x/y"})
    EXPECT_THAT(read(fmt::format("[content]\nurl = \"{}\"\n", bad)).error().message, HasSubstr("content.url")) << bad;
  EXPECT_THAT(read("[content]\nurl = \"https://x/y\"\nfolder = \"here\"\nevery_min = 0\n").error().message,
              testing::AllOf(HasSubstr("content.folder"), HasSubstr("content.every_min")));
  EXPECT_FALSE(read("[content]\n"));
}

TEST(ReportConfigs, ACertificateHasItsKeyAndTls) {
  const auto folder = report_folder("client-certificate");
  for (const auto* file : {"a.pem", "a.key"}) ASSERT_TRUE(write_text_file(folder / file, ""));
  const auto with = [&](const std::string& more) { return read("[mqtt]\nhost = \"broker\"\n" + more, folder); };
  EXPECT_TRUE(with("cert_file = \"a.pem\"\nkey_file = \"a.key\"\n"));
  EXPECT_THAT(with("cert_file = \"a.pem\"\n").error().message, HasSubstr("mqtt.key_file"));
  EXPECT_THAT(with("key_file = \"a.key\"\n").error().message, HasSubstr("mqtt.cert_file"));
  EXPECT_THAT(with("tls = false\ncert_file = \"a.pem\"\nkey_file = \"a.key\"\n").error().message,
              HasSubstr("mqtt.tls"));
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
