// The kiosk's state on a real broker: that comes, goes, wants a password, has a certificate of its own, or says nothing.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "report/channels/mqtt_channel.hpp"
#include "report/channels/mqtt_messages.hpp"
#include "tests/report/certificates.hpp"
#include "tests/report/mqtt_broker.hpp"

namespace kasumi::report {
namespace {

using testing::HasSubstr, testing::Not;

int lines_with(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; ++at) ++count;
  return count;
}

std::string mqtt_table(const MqttBroker& broker, const std::string& more = "tls = false") {
  return fmt::format("[mqtt]\nhost = \"127.0.0.1\"\nport = {}\ntopic = \"kasumi/hill\"\n{}\n", broker.port, more);
}

// An empty object for what is none.
nlohmann::json json_of(const std::string& text) {
  auto json = parse_json(text);
  return json.is_object() ? json : nlohmann::json::object();
}

TEST(MqttMessages, SayWhatVisitorsSeeAndWhatIsWrong) {
  const auto well = json_of(mqtt_state(heard_of(kGoodStatus), Language::english));
  EXPECT_EQ(well["sight"], "live");
  EXPECT_EQ(well["well"], true);
  EXPECT_EQ(well["wrong"], "Nothing is wrong.");
  EXPECT_EQ(well["turbidity"], 2.41);
  EXPECT_EQ(well["visibility_m"], 32000.0);
  EXPECT_EQ(well["temperature_celsius"], 51.5);
  const auto lost = json_of(mqtt_state(heard_of(kLostStatus), *parse_language("de")));
  EXPECT_EQ(lost["well"], false);
  EXPECT_EQ(lost["scene_camera"], false);
  EXPECT_EQ(lost["symptoms"][0], "scene-lost");
  EXPECT_THAT(lost["wrong"].get<std::string>(), HasSubstr("amera"));
  const auto silent = json_of(mqtt_state({Contact::silent, std::nullopt, "why", {}}, Language::english));
  EXPECT_EQ(silent["sight"], "unknown");
  EXPECT_EQ(silent["symptoms"][0], "silent");
  EXPECT_TRUE(silent["turbidity"].is_null());
  EXPECT_TRUE(silent["scene_camera"].is_null());
}

// Whatever a hostile status holds is text within JSON.
TEST(MqttMessages, AreJsonWhateverTheKioskSays) {
  const auto hostile = changed(kLostStatus, "\"cause\": \"\"", R"("cause": "\"}, {{ x }}\u0000\ud83d\ude00")");
  EXPECT_TRUE(nlohmann::json::accept(mqtt_state(heard_of(hostile), *parse_language("ja"))));
}

TEST(MqttMessages, HomeAssistantIsToldOfEntitiesThatAreInTheState) {
  const auto state = json_of(mqtt_state(heard_of(kGoodStatus), Language::english));
  std::set<std::string> ids, topics;
  for (const auto& [topic, payload] : discovery_messages("ha", "kasumi/the hill", "Hill", *parse_language("fr"))) {
    const auto entity = json_of(payload);
    ASSERT_TRUE(entity.is_object()) << payload;
    EXPECT_THAT(topic, testing::MatchesRegex("ha/(binary_)?sensor/kasumi_the_hill/[a-z0-9_]+/config"));
    EXPECT_EQ(entity["state_topic"], "kasumi/the hill/state");
    EXPECT_EQ(entity["availability_topic"], "kasumi/the hill/available");
    EXPECT_EQ(entity["device"]["name"], "Hill");
    EXPECT_FALSE(entity["name"].get<std::string>().empty());
    ids.insert(entity["unique_id"].get<std::string>());
    topics.insert(topic);
    const auto from = entity["value_template"].get<std::string>();
    const auto at = from.find("value_json.");
    ASSERT_NE(at, std::string::npos);
    const auto key =
        from.substr(at + 11, from.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789", at + 11) - at - 11);
    EXPECT_TRUE(state.contains(key)) << key;
  }
  EXPECT_EQ(ids.size(), topics.size());
  EXPECT_GE(ids.size(), 10u);
}

TEST(MqttMessages, TopicsAreThoseThatBrokersTake) {
  for (const auto* good : {"kasumi", "kasumi/hill", "a/b/c-1.2_3"}) EXPECT_TRUE(is_topic(good)) << good;
  for (const auto* bad : {"", "/a", "a/", "a//b", "$SYS/a", "a/+", "#", "a b", "a\nb"})
    EXPECT_FALSE(is_topic(bad)) << bad;
  EXPECT_FALSE(is_topic(std::string(129, 'a')));
}

class Mqtt : public testing::Test {
 protected:
  void SetUp() override {
    if (!has_mosquitto()) GTEST_SKIP() << "mosquitto is not installed (packages mosquitto, mosquitto-clients)";
  }
};

TEST_F(Mqtt, StateArrivesAndIsThereForALateSubscriber) {
  const MqttBroker broker(report_folder("mqtt-broker"));
  RunningReporter reporter("mqtt", {}, mqtt_table(broker, "tls = false\nevery_s = 3600"));
  const auto state = [&] { return json_of(broker.retained("kasumi/hill/state")); };
  ASSERT_TRUE(within(20, [&] { return broker.retained("kasumi/hill/available", 1) == "online"; })) << reporter.log();
  EXPECT_EQ(state()["sight"], "live");
  EXPECT_EQ(json_of(broker.retained("homeassistant/binary_sensor/kasumi_hill/well/config"))["device_class"], "problem");
  // What visitors see is told at once, not with the figures.
  reporter.tell(kLostStatus);
  EXPECT_TRUE(within(10, [&] { return state()["sight"] == "still"; }));
  EXPECT_EQ(state()["symptoms"][0], "scene-lost");
  EXPECT_THAT(reporter.metrics(), HasSubstr("kasumi_report_mqtt_connected 1\n"));
  // It says goodbye.
  EXPECT_EQ(reporter.child().stop(), 0);
  EXPECT_EQ(broker.retained("kasumi/hill/available"), "offline");
  EXPECT_EQ(reporter.log(), "");
}

TEST_F(Mqtt, TheLastWillIsToldWhenTheReporterIsKilled) {
  const MqttBroker broker(report_folder("mqtt-will-broker"));
  RunningReporter reporter("mqtt-will", {}, mqtt_table(broker));
  ASSERT_TRUE(within(20, [&] { return broker.retained("kasumi/hill/available", 1) == "online"; })) << reporter.log();
  ASSERT_TRUE(within(20, [&] { return !broker.retained("kasumi/hill/state", 1).empty(); })) << reporter.log();
  reporter.child().stop(SIGKILL);
  EXPECT_TRUE(within(10, [&] { return broker.retained("kasumi/hill/available", 1) == "offline"; }));
  EXPECT_EQ(json_of(broker.retained("kasumi/hill/state"))["sight"], "live") << "as it was known last";
}

TEST_F(Mqtt, Row27ABrokerThatComesBackIsToldAgain) {
  MqttBroker broker(report_folder("mqtt-back-broker"));  // which keeps nothing on a disk
  RunningReporter reporter("mqtt-back", {}, mqtt_table(broker, "tls = false\nevery_s = 3600"));
  const auto is_away = [&] { return reporter.metrics().find("kasumi_report_mqtt_connected 0\n") != std::string::npos; };
  const auto sees = [&](const char* sight) {
    return json_of(broker.retained("kasumi/hill/state", 1)).value("sight", "") == sight;
  };
  ASSERT_TRUE(within(20, [&] { return sees("live"); })) << reporter.log();
  broker.stop();
  EXPECT_TRUE(within(10, is_away));
  broker.start();
  EXPECT_TRUE(within(30, [&] { return sees("live"); })) << "what has not changed is told, too";
  broker.stop();
  EXPECT_TRUE(within(10, is_away));
  reporter.tell(kLostStatus);
  std::this_thread::sleep_for(std::chrono::seconds(5));  // several tries
  broker.start();
  EXPECT_TRUE(within(30, [&] { return sees("still"); }));
  EXPECT_EQ(broker.retained("kasumi/hill/available"), "online");
  EXPECT_EQ(lines_with(reporter.log(), ": connected\n"), 2) << reporter.log();
  EXPECT_LE(lines_with(reporter.log(), "\n"), 6) << reporter.log();  // lost, refused, connected; twice
}

TEST_F(Mqtt, AWrongPasswordIsToldOnceInPlainWords) {
  const auto folder = report_folder("mqtt-password-broker");
  ASSERT_EQ(said_by("mosquitto_passwd -b -c " + (folder / "passwords").string() + " hill correct-horse"), "");
  const MqttBroker broker(folder, "allow_anonymous false\npassword_file " + (folder / "passwords").string());
  ASSERT_TRUE(write_text_file(folder / "wrong", "battery-staple\n"));
  ASSERT_TRUE(write_text_file(folder / "right", "correct-horse\n"));
  const auto with = [&](const std::string& file) {
    return mqtt_table(broker,
                      fmt::format("tls = false\nuser = \"hill\"\npassword_file = \"{}\"", (folder / file).string()));
  };
  {
    RunningReporter reporter("mqtt-wrong", {}, with("wrong"));
    EXPECT_TRUE(within(20, [&] { return !reporter.log().empty(); }));
    std::this_thread::sleep_for(std::chrono::seconds(4));  // several tries
    EXPECT_EQ(lines_with(reporter.log(), "\n"), 1) << reporter.log();
    EXPECT_THAT(reporter.log(), HasSubstr("it refuses the user \"hill\": wrong user or password"));
    EXPECT_THAT(reporter.log(), Not(HasSubstr("battery")));
    EXPECT_THAT(reporter.metrics(), HasSubstr("kasumi_up 1\n"));
  }
  RunningReporter nobody("mqtt-nobody", {}, mqtt_table(broker));
  EXPECT_TRUE(within(20, [&] { return nobody.log().find("it asks for a user and a password") != std::string::npos; }))
      << nobody.log();
  RunningReporter reporter("mqtt-right", {}, with("right"));
  const std::string me = "-u hill -P correct-horse";
  EXPECT_TRUE(within(20, [&] { return broker.retained("kasumi/hill/available", 1, me) == "online"; }))
      << reporter.log();
}

TEST_F(Mqtt, TlsTrustsTheGivenAuthorityAndNobodyElse) {
  if (!is_installed("openssl")) GTEST_SKIP() << "openssl is not installed";
  const auto folder = report_folder("mqtt-tls-broker");
  make_certificates(folder);
  const auto broker_of = [&](const std::string& name) {
    return fmt::format("allow_anonymous true\ncertfile {0}/{1}.pem\nkeyfile {0}/{1}.key", folder.string(), name);
  };
  const auto trusting = [&](const std::string& ca) {
    return fmt::format("ca_file = \"{}/{}.pem\"", folder.string(), ca);
  };
  const MqttBroker broker(folder, broker_of("own"));
  const auto as_ca = fmt::format("--cafile {}/ca.pem", folder.string());
  {
    RunningReporter reporter("mqtt-tls", {}, mqtt_table(broker, trusting("ca")));
    EXPECT_TRUE(within(20, [&] { return broker.retained("kasumi/hill/available", 1, as_ca) == "online"; }))
        << reporter.log();
    EXPECT_EQ(json_of(broker.retained("kasumi/hill/state", 3, as_ca))["sight"], "live");
    EXPECT_EQ(reporter.log(), "");
  }
  const auto refused = [&](const std::string& name, const std::string& table) {
    RunningReporter reporter(name, {}, table);
    EXPECT_TRUE(within(20, [&] { return reporter.log().find("SSL") != std::string::npos; })) << reporter.log();
    std::this_thread::sleep_for(std::chrono::seconds(2));
    EXPECT_EQ(lines_with(reporter.log(), "\n"), 1) << reporter.log();
    EXPECT_THAT(reporter.metrics(), HasSubstr("kasumi_report_mqtt_connected 0\n"));
  };
  refused("mqtt-stranger", mqtt_table(broker, trusting("stranger")));
  refused("mqtt-public", mqtt_table(broker, ""));
  // Signed by whom we trust, but for another host.
  const auto other_folder = report_folder("mqtt-other-broker");
  const MqttBroker other(other_folder, broker_of("other"));
  refused("mqtt-other", mqtt_table(other, trusting("ca")));
}

TEST_F(Mqtt, ABrokerThatAsksWhoWeAreIsShownOurCertificate) {
  if (!is_installed("openssl")) GTEST_SKIP() << "openssl is not installed";
  const auto folder = report_folder("mqtt-client-broker");
  make_certificates(folder);
  const MqttBroker broker(folder,
                          fmt::format("require_certificate true\nuse_identity_as_username true\ncafile {0}/ca.pem\n"
                                      "certfile {0}/own.pem\nkeyfile {0}/own.key",
                                      folder.string()));
  const auto shown = [&](const std::string& who) {
    return fmt::format(
        "ca_file = \"{0}/ca.pem\"\n{1}", folder.string(),
        who.empty() ? std::string()
                    : fmt::format("cert_file = \"{0}/{1}.pem\"\nkey_file = \"{0}/{1}.key\"\n", folder.string(), who));
  };
  const auto me = fmt::format("--cafile {0}/ca.pem --cert {0}/own.pem --key {0}/own.key", folder.string());
  {
    RunningReporter reporter("mqtt-client", {}, mqtt_table(broker, shown("other")));
    EXPECT_TRUE(within(20, [&] { return broker.retained("kasumi/hill/available", 1, me) == "online"; }))
        << reporter.log();
    EXPECT_EQ(reporter.log(), "");
  }
  for (const auto& who : {std::string("stranger"), std::string()}) {
    RunningReporter reporter("mqtt-client-" + who, {}, mqtt_table(broker, shown(who)));
    EXPECT_TRUE(within(20, [&] { return !reporter.log().empty(); }));
    std::this_thread::sleep_for(std::chrono::seconds(2));
    EXPECT_EQ(broker.retained("kasumi/hill/available", 1, me), "offline") << who;
    EXPECT_THAT(reporter.metrics(), HasSubstr("kasumi_report_mqtt_connected 0\n"));
  }
}

// A network that fails in two ways by turns, as one does whose cable is loose.
TEST_F(Mqtt, EachCauseOfAnOutageIsToldOnceHoweverTheyAlternate) {
  using namespace std::chrono_literals;
  MqttOptions options;
  options.host = "127.0.0.1";
  options.port = free_port();
  options.tls = false;
  options.topic = "kasumi/hill";
  testing::internal::CaptureStderr();
  {
    SystemClock clock;
    MqttChannel channel(options, "Hill", Language::english, clock,
                        {.first_wait = 20ms, .longest_wait = 20ms, .silence = 300ms});
    for (int turn = 0; turn < 4; ++turn) {
      std::this_thread::sleep_for(400ms);  // nobody listens: refused
      const UniqueFd silent(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
      const int again = 1;
      ::setsockopt(silent.value(), SOL_SOCKET, SO_REUSEADDR, &again, sizeof again);
      sockaddr_in address{};
      address.sin_family = AF_INET;
      address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      address.sin_port = htons(static_cast<std::uint16_t>(options.port));
      ASSERT_EQ(::bind(silent.value(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
      ASSERT_EQ(::listen(silent.value(), 4), 0);
      std::this_thread::sleep_for(1200ms);
    }
  }
  const auto log = testing::internal::GetCapturedStderr();
  EXPECT_EQ(lines_with(log, "it does not answer"), 1) << log;
  EXPECT_EQ(lines_with(log, "refused"), 1) << log;
  EXPECT_LE(lines_with(log, "\n"), 3) << log;  // closing its port ends a connection in a way of its own
}

// A port where somebody listens and never says a word; and one that never even connects.
TEST_F(Mqtt, Row27ABrokerThatSaysNothingCostsNothing) {
  const UniqueFd silent(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  ASSERT_EQ(::bind(silent.value(), reinterpret_cast<sockaddr*>(&address), length), 0);
  ASSERT_EQ(::listen(silent.value(), 4), 0);
  ::getsockname(silent.value(), reinterpret_cast<sockaddr*>(&address), &length);
  for (const auto& [name, host, tls] : {std::tuple{"mqtt-silent", "127.0.0.1", "false"},
                                        {"mqtt-silent-tls", "127.0.0.1", "true"},
                                        {"mqtt-nowhere", "192.0.2.1", "true"}}) {
    RunningReporter reporter(
        name, {}, fmt::format("[mqtt]\nhost = \"{}\"\nport = {}\ntls = {}\n", host, ntohs(address.sin_port), tls));
    [[maybe_unused]] double before_kb = 0.0;
    double longest_s = 0.0;
    for (int i = 0; i < 40; ++i) {
      if (i == 10) before_kb = reporter.child().memory_kb();  // once all that is needed was used
      reporter.tell(i % 2 ? kLostStatus : kGoodStatus);       // news each time
      const auto began = std::chrono::steady_clock::now();
      EXPECT_THAT(reporter.metrics(), HasSubstr("kasumi_report_mqtt_connected 0\n"));
      longest_s = std::max(longest_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    EXPECT_LT(longest_s, 5.0) << name;
    // Sanitizers multiply memory; what they find counts then.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    EXPECT_LT(reporter.child().memory_kb(), before_kb + 2048) << name;
#endif
    const auto began = std::chrono::steady_clock::now();
    EXPECT_EQ(reporter.child().stop(), 0) << name;
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count(), 8.0) << name;
  }
}

}  // namespace
}  // namespace kasumi::report
