// A fleet on one desk: three kiosks on recordings, their reporters, a broker, a Prometheus and an Alertmanager. One camera and one clock are
// broken, one dome is dirty, one reporter is killed; what an operator far away would read is read in every channel.
#include <gmock/gmock.h>

#include <regex>
#include <stop_token>
#include <thread>

#include "base/outside/json_text.hpp"
#include "pipeline/kiosk/appliance/status.hpp"
#include "tests/pipeline/kiosk/appliance/kiosk_process.hpp"
#include "tests/report/mqtt_broker.hpp"

namespace kasumi::report {
namespace {

using testing::AllOf, testing::HasSubstr, testing::Not;

// A kiosk and its reporter, which share a folder as they do on a machine.
class Site {
 public:
  // `kiosk`: whether it has one of its own; else somebody has to tell it a status.
  Site(const std::string& name, int broker, bool kiosk = true)
      : name_(name), folder(process_folder("fleet-" + name)), port(free_port()) {
    if (kiosk) prepare_kiosk();
    start_reporter(broker);
  }
  void prepare_kiosk() {
    // A recording of its own, which can be broken.
    std::filesystem::copy(bench_fixture(), folder / "recording", std::filesystem::copy_options::recursive);
    auto text = read_text_file(folder / "kasumi.toml").value();
    for (int i = 0; i < 2; ++i) text = changed(text, "\"" + bench_fixture().string() + "\"", "\"recording\"");
    EXPECT_TRUE(write_text_file(folder / "kasumi.toml", text));
    start_kiosk();
  }
  void start_reporter(int broker) {
    EXPECT_TRUE(write_text_file(folder / "sendmail", "#!/bin/sh\ncat >>$(dirname $0)/mails\n"));
    std::filesystem::permissions(folder / "sendmail", std::filesystem::perms(0755));
    EXPECT_TRUE(
        write_text_file(folder / "report.toml",
                        fmt::format("[kiosk]\nname = \"{0}\"\nstatus = \"{1}/status.json\"\nstate = \"{1}/state\"\n"
                                    "[http]\nport = {2}\n[mqtt]\nhost = \"127.0.0.1\"\nport = {3}\ntls = false\n"
                                    "topic = \"kasumi/{0}\"\nevery_s = 2\n[mail]\nto = [\"me@example.org\"]\n"
                                    "command = [\"{1}/sendmail\"]\nmemory_file = \"{1}/mail.txt\"\n",
                                    name_, folder.string(), port, broker)));
    reporter.emplace(std::vector<std::string>{report_program(), "run", "--config", folder / "report.toml"},
                     folder / "report.log");
  }
  void start_kiosk() {
    kiosk_.emplace(folder, std::vector<std::string>{"run", "--config", (folder / "kasumi.toml").string()},
                   std::string(), folder / "state");
  }
  // As after a night without a battery: the clock's time is one that cannot be.
  void restart_without_a_clock() {
    kiosk_.reset();
    const auto text = read_text_file(folder / "kasumi.toml").value();
    EXPECT_TRUE(write_text_file(folder / "kasumi.toml",
                                changed(text, "[clock]\npolicy = \"trusted\"",
                                        "[clock]\npolicy = \"synchronized\"\nearliest_utc = 2200-01-01T00:00:00Z")));
    start_kiosk();
  }
  void break_scene_camera() const { std::filesystem::remove_all(folder / "recording" / "scene"); }

  std::string get(const std::string& path) const {
    const auto fd = connected(port);
    if (!fd || !sent(fd, fmt::format("GET {} HTTP/1.0\r\nHost: localhost\r\n\r\n", path))) return {};
    return heard_from(fd);
  }
  std::string mails() const { return read_text_file(folder / "mails").value_or(""); }
  std::string show() const {
    return said_by(
        fmt::format("{} show --status {}/status.json; echo code $?", report_program().string(), folder.string()));
  }
  std::string logs() const {
    return read_text_file(folder / "report.log").value_or("") + (kiosk_ ? kiosk_->log() : std::string());
  }

 private:
  std::string name_;

 public:
  const std::filesystem::path folder;
  const int port;
  std::optional<Child> reporter;

 private:
  std::optional<Process> kiosk_;
};

// What a kiosk tells whose daily check has found this: another's status, as it is written, but for that.
class Relay {
 public:
  Relay(const Site& from, const Site& to, const CheckStatus& check) {
    Status status;
    status.check = check;
    auto found = parse_ordered_json(status_json(status))["check"];
    thread_ = std::jthread([file = from.folder / "status.json", to = to.folder / "status.json",
                            found = std::move(found)](const std::stop_token& stop) {
      for (; !stop.stop_requested(); std::this_thread::sleep_for(500ms)) {
        auto json = parse_ordered_json(read_text_file(file).value_or(""));
        if (!json.is_object()) continue;
        json["check"] = found;
        (void)write_text_file(to, json.dump());
      }
    });
  }

 private:
  std::jthread thread_;
};

TEST(Fleet, AnOperatorFarAwayLearnsWhatIsWrongAndWhere) {
  if (!has_mosquitto()) GTEST_SKIP() << "mosquitto is not installed (packages mosquitto, mosquitto-clients)";
  for (const auto* server : {"prometheus", "prometheus-alertmanager"})
    if (!is_installed(server)) GTEST_SKIP() << server << " is not installed";
  const auto folder = report_folder("fleet");
  const MqttBroker broker(folder);
  Site hill("hill", broker.port), dale("dale", broker.port), shore("shore", broker.port),
      moor("moor", broker.port, false);
  DriftReport soiled;
  soiled.findings = {
      {"sky", "dome", DriftState::drifted, "spots on the dome: 4.1 percent, allowed 1", 4.1, 0.2, 1.0, "percent"}};
  const Relay relay(dale, moor, {std::chrono::system_clock::now(), drift_summary(soiled), soiled});

  auto rules = read_text_file(source_folder() / "systemd/report/kasumi.rules.yml").value();
  rules = std::regex_replace(rules, std::regex("for: (1|2|5|10)m"), "for: 1s");
  ASSERT_TRUE(write_text_file(folder / "kasumi.rules.yml", rules));
  const int prometheus_port = free_port(), alertmanager_port = free_port();
  ASSERT_TRUE(write_text_file(
      folder / "prometheus.yml",
      fmt::format("global: {{scrape_interval: 1s, scrape_timeout: 1s, evaluation_interval: 1s}}\n"
                  "rule_files: [kasumi.rules.yml]\nscrape_configs: [{{job_name: kasumi, static_configs: "
                  "[{{targets: ['127.0.0.1:{}', '127.0.0.1:{}', '127.0.0.1:{}', '127.0.0.1:{}']}}]}}]\n"
                  "alerting: {{alertmanagers: [{{static_configs: [{{targets: ['127.0.0.1:{}']}}]}}]}}\n",
                  hill.port, dale.port, shore.port, moor.port, alertmanager_port)));
  ASSERT_TRUE(write_text_file(folder / "alertmanager.yml", "route: {receiver: nobody}\nreceivers: [{name: nobody}]\n"));
  const Child alertmanager({"prometheus-alertmanager", "--config.file=" + (folder / "alertmanager.yml").string(),
                            "--storage.path=" + (folder / "alerts").string(), "--cluster.listen-address=",
                            fmt::format("--web.listen-address=127.0.0.1:{}", alertmanager_port)},
                           folder / "alertmanager.log");
  const Child prometheus({"prometheus", "--config.file=" + (folder / "prometheus.yml").string(),
                          "--storage.tsdb.path=" + (folder / "data").string(),
                          fmt::format("--web.listen-address=127.0.0.1:{}", prometheus_port)},
                         folder / "prometheus.log");
  // Whether that alert of that kiosk has reached Alertmanager, which calls people.
  const auto alert = [&](const std::string& name, const Site& site) {
    const auto fd = connected(alertmanager_port);
    const auto request = fmt::format(
        "GET /api/v2/alerts?filter=alertname%3D%22{}%22&filter=instance%3D%22127.0.0.1%3A{}%22 HTTP/1.0\r\n"
        "Host: localhost\r\n\r\n",
        name, site.port);
    return fd && sent(fd, request) && heard_from(fd).find("\"alertname\":\"" + name + "\"") != std::string::npos;
  };
  const auto state = [&](const std::string& name) {
    const auto json = parse_json(broker.retained("kasumi/" + name + "/state", 2));
    return json.is_object() ? json : nlohmann::json::object();
  };
  const auto sees = [&](const std::string& name, const std::string& sight) {
    return eventually([&] { return state(name).value("sight", "") == sight; }, 180s);
  };

  for (const auto* name : {"hill", "dale", "shore", "moor"}) ASSERT_TRUE(sees(name, "live")) << name << hill.logs();
  EXPECT_THAT(hill.show(), HasSubstr("code 0\n"));

  hill.break_scene_camera();
  shore.restart_without_a_clock();
  ASSERT_TRUE(sees("hill", "still")) << hill.logs();
  ASSERT_TRUE(sees("shore", "no-building")) << shore.logs();

  // The broker, and Home Assistant behind it.
  EXPECT_EQ(state("hill")["well"], false);
  EXPECT_EQ(state("hill")["scene_camera"], false);
  EXPECT_THAT(state("hill")["symptoms"].dump(), HasSubstr("scene-lost"));
  EXPECT_THAT(state("shore")["symptoms"].dump(), AllOf(HasSubstr("clock-unset"), Not(HasSubstr("scene-lost"))));
  EXPECT_EQ(state("dale")["symptoms"].dump(), "[]");
  EXPECT_EQ(state("moor")["symptoms"].dump(), "[\"camera-soiled\"]");
  EXPECT_EQ(state("moor")["well"], true) << "visitors see the building";
  EXPECT_THAT(state("moor")["wrong"].get<std::string>(), HasSubstr("dirty"));
  // Prometheus and Alertmanager.
  EXPECT_TRUE(eventually([&] { return alert("KasumiPictureGone", hill) && alert("KasumiCameraDown", hill); }));
  EXPECT_TRUE(eventually([&] { return alert("KasumiPictureGone", shore) && alert("KasumiClock", shore); }));
  EXPECT_TRUE(eventually([&] { return alert("KasumiCameraDirty", moor); }));
  EXPECT_FALSE(alert("KasumiPictureGone", moor)) << "nobody is called out at night for a dirty dome";
  for (const auto* name :
       {"KasumiPictureGone", "KasumiCameraDown", "KasumiClock", "KasumiUnreachable", "KasumiCameraDirty"})
    EXPECT_TRUE(eventually([&] { return !alert(name, dale); })) << name;
  EXPECT_FALSE(alert("KasumiCameraDown", shore));
  // A browser, and a terminal.
  EXPECT_THAT(hill.get("/?language=de"), HasSubstr("Szenenkamera"));
  EXPECT_THAT(hill.show(), AllOf(HasSubstr("camera"), HasSubstr("code 1\n")));
  EXPECT_THAT(shore.show(), AllOf(HasSubstr("clock"), HasSubstr("code 1\n")));
  EXPECT_THAT(dale.show(), HasSubstr("code 0\n"));
  EXPECT_THAT(moor.get("/?language=de"), AllOf(HasSubstr("Kuppel"), HasSubstr("4.1 percent")));
  EXPECT_THAT(moor.get("/metrics"), HasSubstr("kasumi_drifted{camera=\"sky\",what=\"dome\"} 1\n"));
  EXPECT_THAT(moor.show(), AllOf(HasSubstr("dirty"), HasSubstr("4.1 percent"), HasSubstr("code 0\n")));
  // Mail: of the camera within a minute; the clock may yet be set, and nothing is wrong in the dale.
  EXPECT_TRUE(eventually([&] { return !hill.mails().empty(); }, 120s)) << hill.logs();
  EXPECT_THAT(hill.mails(), AllOf(HasSubstr("Subject: [hill] "), HasSubstr("camera")));
  EXPECT_EQ(dale.mails(), "");
  EXPECT_TRUE(eventually([&] { return !moor.mails().empty(); }, 120s));
  EXPECT_THAT(moor.mails(), AllOf(HasSubstr("Subject: [moor] "), HasSubstr("dirty"), HasSubstr("4.1 percent")));

  // A machine that is gone says nothing; others say so.
  dale.reporter->stop(SIGKILL);
  EXPECT_TRUE(eventually([&] { return broker.retained("kasumi/dale/available", 2) == "offline"; }));
  EXPECT_TRUE(eventually([&] { return alert("KasumiUnreachable", dale); }));
  EXPECT_FALSE(alert("KasumiUnreachable", hill));
  EXPECT_EQ(hill.reporter->stop(), 0);
  EXPECT_EQ(shore.reporter->stop(), 0);
}

}  // namespace
}  // namespace kasumi::report
