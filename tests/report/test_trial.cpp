// The trial of every channel, as an operator asks for it: by the command, and from within the service.
#include <gmock/gmock.h>

#include "tests/report/mqtt_broker.hpp"
#include "tests/report/web_server.hpp"

namespace kasumi::report {
namespace {

using testing::AllOf, testing::HasSubstr, testing::Not;

struct Trials : testing::Test {
  void SetUp() override {
    if (!has_mosquitto() || !has_nginx() || !is_installed("openssl"))
      GTEST_SKIP() << "mosquitto, nginx or openssl is not installed";
    folder = report_folder("trial");
    make_certificates(folder);
    std::filesystem::create_directories(folder / "www");
    EXPECT_TRUE(write_text_file(folder / "www/hill.kasumi", "a bundle"));
    EXPECT_TRUE(write_text_file(folder / "www/ping", "OK"));
    EXPECT_TRUE(write_text_file(folder / "sendmail",
                                "#!/bin/sh\ncat >$(dirname $0)/mail.part; mv $(dirname $0)/mail.part "
                                "$(dirname $0)/mail\n"));
    std::filesystem::permissions(folder / "sendmail", std::filesystem::perms(0755));
    EXPECT_TRUE(write_text_file(folder / "status.json", kGoodStatus));
    server.emplace(folder);
    broker.emplace(folder);
  }
  void configure(int broker_port, const std::string& language = "en") const {
    EXPECT_TRUE(write_text_file(
        folder / "report.toml",
        fmt::format("[kiosk]\nname = \"Hill\"\nlanguage = \"{4}\"\nstatus = \"{0}/status.json\"\nstate = \"{0}\"\n"
                    "[mail]\nto = [\"me@example.org\"]\ncommand = [\"{0}/sendmail\"]\nmemory_file = \"{0}/memory\"\n"
                    "[mqtt]\nhost = \"127.0.0.1\"\nport = {1}\ntls = false\ntopic = \"kasumi/hill\"\n"
                    "[sign_of_life]\nurl = \"{2}\"\nca_file = \"{0}/ca.pem\"\n"
                    "[content]\nurl = \"{3}\"\nca_file = \"{0}/ca.pem\"\nfolder = \"{0}/state\"\n",
                    folder.string(), broker_port, server->url("ping?secret"), server->url("hill.kasumi"), language)));
  }
  std::string tried() const {
    return said_by(
        fmt::format("{} try --config {}/report.toml; echo code $?", report_program().string(), folder.string()));
  }
  std::string mail() const { return read_text_file(folder / "mail").value_or(""); }
  std::filesystem::path folder;
  std::optional<WebServer> server;
  std::optional<MqttBroker> broker;
};

TEST_F(Trials, SayWhatCameOfEachChannel) {
  configure(broker->port);
  const Child listener({"mosquitto_sub", "-h", "127.0.0.1", "-p", std::to_string(broker->port), "-t",
                        "kasumi/hill/trial", "-C", "1", "-W", "60"},
                       folder / "heard");
  std::this_thread::sleep_for(std::chrono::seconds(1));  // it subscribes
  const auto said = tried();
  EXPECT_THAT(said, AllOf(HasSubstr("mail: " + (folder / "sendmail").string() + " has taken a mail to me@example.org"),
                          HasSubstr("has taken a message on kasumi/hill/trial"), HasSubstr("has taken a sign of life"),
                          HasSubstr("has the bundle"), HasSubstr("code 0\n"), Not(HasSubstr("secret"))));
  EXPECT_THAT(mail(), AllOf(HasSubstr("To: me@example.org\nSubject: [Hill] Trial mail\n"), HasSubstr("was asked for")));
  EXPECT_TRUE(
      within(10, [&] { return read_text_file(folder / "heard").value_or("").find("trial_utc") != std::string::npos; }));
  EXPECT_EQ(broker->retained("kasumi/hill/trial", 1), "") << "nobody hears of it later";
  EXPECT_FALSE(std::filesystem::exists(folder / "memory")) << "a trial is no news";
  configure(broker->port, "ja");
  EXPECT_THAT(tried(), HasSubstr("code 0\n"));
  EXPECT_THAT(mail(), HasSubstr("によるものです。"));
}

TEST_F(Trials, ThatFailSayWhy) {
  configure(free_port());
  EXPECT_TRUE(write_text_file(folder / "sendmail", "#!/bin/sh\necho no such relay >&2; exit 69\n"));
  std::filesystem::permissions(folder / "sendmail", std::filesystem::perms(0755));
  EXPECT_TRUE(write_text_file(folder / "status.json", kLostStatus));
  std::filesystem::remove(folder / "www/hill.kasumi");
  const auto said = tried();
  EXPECT_THAT(said, AllOf(HasSubstr("mail: failed: "), HasSubstr("exit code 69: no such relay"),
                          HasSubstr("mqtt: failed: "), HasSubstr("Connection refused"), HasSubstr("content: failed: "),
                          HasSubstr("it answers 404"), HasSubstr("code 1\n")));
  EXPECT_THAT(said, HasSubstr("sign_of_life: not tried")) << "whoever waits for it would believe it";
  EXPECT_THAT(server->asked(), Not(HasSubstr("200 - 2")));
}

// As the service may do less than whoever types.
TEST_F(Trials, AreMadeByTheServiceItself) {
  configure(broker->port);
  Child reporter({report_program(), "run", "--config", folder / "report.toml"}, folder / "log");
  const auto log = [&] { return read_text_file(folder / "log").value_or(""); };
  ASSERT_TRUE(within(20, [&] { return broker->retained("kasumi/hill/available", 1) == "online"; })) << log();
  ::kill(reporter.pid(), SIGUSR1);
  EXPECT_TRUE(within(20, [&] { return log().find("<5>trial: content: ") != std::string::npos; })) << log();
  EXPECT_THAT(log(), AllOf(HasSubstr("<5>trial: mail: "), HasSubstr("<5>trial: mqtt: ")));
  EXPECT_EQ(broker->retained("kasumi/hill/available", 1), "online") << "it goes on beside it";
  EXPECT_EQ(reporter.stop(), 0);
}

}  // namespace
}  // namespace kasumi::report
