// What Prometheus reads: by promtool, by a Prometheus, and by a disk that node_exporter looks at.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "report/channels/metrics.hpp"
#include "tests/report/running_reporter.hpp"

namespace kasumi::report {
namespace {

using testing::HasSubstr, testing::Not;

std::string metrics_of(const Heard& heard) {
  OwnFigures own;
  own.answered["200"] = 3;
  own.refused["slow \"peer\"\\\n"] = 1;
  own.resident_bytes = 9e6;
  return metrics_text(heard, DiskFigures{5e9, 2e10}, own);
}

TEST(Metrics, TellWhatTheStatusTells) {
  const auto text = metrics_of(heard_of(kGoodStatus));
  for (const auto* line :
       {"kasumi_up 1\n", "kasumi_picture_well 1\n", "kasumi_sight{sight=\"live\"} 1\n",
        "kasumi_sight{sight=\"still\"} 0\n", "kasumi_symptom{symptom=\"scene-lost\"} 0\n",
        "kasumi_camera_up{camera=\"sky\"} 1\n", "kasumi_camera_bad_frames_total{camera=\"scene\"} 3\n",
        "kasumi_turbidity 2.41\n", "kasumi_aod_550nm_sigma 0.01\n", "kasumi_latency_p95_seconds 0.0804\n",
        "kasumi_drifted{camera=\"sky\",what=\"dome\"} 0\n", "kasumi_state_disk_free_bytes 5000000000\n",
        "kasumi_clock_trusted 1\n", "kasumi_start_time_seconds 1781942400\n",
        "kasumi_report_refused_total{why=\"slow \\\"peer\\\"\\\\ \"} 1\n"})
    EXPECT_THAT(text, HasSubstr(line));
}

TEST(Metrics, OfASilentKioskSaySoAndClaimNothingElse) {
  const auto text = metrics_of({Contact::silent, std::nullopt, "why", {}});
  EXPECT_THAT(text, HasSubstr("kasumi_up 0\n"));
  EXPECT_THAT(text, HasSubstr("kasumi_picture_well 0\n"));
  EXPECT_THAT(text, HasSubstr("kasumi_symptom{symptom=\"silent\"} 1\n"));
  EXPECT_THAT(text, Not(HasSubstr("kasumi_turbidity")));
  EXPECT_THAT(text, Not(HasSubstr("kasumi_camera_up")));
}

TEST(Metrics, WhatIsUnknownIsLeftOut) {
  const auto text = metrics_of(heard_of("{}"));
  EXPECT_THAT(text, Not(HasSubstr("kasumi_turbidity")));
  EXPECT_THAT(text, Not(HasSubstr("nan")));
}

TEST(Metrics, PromtoolFindsNothingWrong) {
  if (!is_installed("promtool")) GTEST_SKIP() << "promtool is not installed (package prometheus)";
  const auto folder = report_folder("promtool");
  for (const auto& [name, heard] : {std::pair{"good", heard_of(kGoodStatus)},
                                    {"bare", heard_of("{}")},
                                    {"silent", Heard{Contact::silent, std::nullopt, "why", {}}}}) {
    const auto file = folder / name;
    ASSERT_TRUE(write_text_file(file, metrics_of(heard)));
    EXPECT_EQ(std::system(fmt::format("promtool check metrics < {0} > {0}.log 2>&1", file.string()).c_str()), 0)
        << read_text_file(file.string() + ".log").value_or("");
  }
}

TEST(Metrics, ItsAlertsComeWhenTheyShould) {
  if (!is_installed("promtool")) GTEST_SKIP() << "promtool is not installed (package prometheus)";
  const auto folder = report_folder("rules");
  std::filesystem::copy_file(source_folder() / "systemd/report/kasumi.rules.yml", folder / "kasumi.rules.yml");
  std::filesystem::copy_file(source_folder() / "tests/report/kasumi.rules.test.yml", folder / "test.yml");
  EXPECT_EQ(
      std::system(fmt::format("cd {} && {{ promtool check rules kasumi.rules.yml && promtool test rules test.yml; "
                              "}} > log 2>&1",
                              folder.string())
                      .c_str()),
      0)
      << read_text_file(folder / "log").value_or("");
}

// A metric that a rule or a panel asks for must exist: a typing error in an expression never fires.
TEST(Metrics, EveryRuleAndPanelAsksForWhatIsThere) {
  const auto text = metrics_of(heard_of(kGoodStatus));
  for (const auto* file : {"systemd/report/kasumi.rules.yml", "systemd/report/grafana-dashboard.json"}) {
    const auto asking = read_text_file(source_folder() / file).value();
    int names = 0;
    for (std::size_t at = 0; (at = asking.find("kasumi_", at)) != std::string::npos;) {
      const auto end = asking.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789", at);
      const auto name = asking.substr(at, end - at);
      EXPECT_THAT(text, HasSubstr("# TYPE " + name + " ")) << file;
      at = end;
      ++names;
    }
    EXPECT_GT(names, 10) << file;
  }
  EXPECT_TRUE(
      nlohmann::json::accept(read_text_file(source_folder() / "systemd/report/grafana-dashboard.json").value()));
}

// Two services of this machine, as on a desk.
TEST(Metrics, APrometheusScrapesThemAndRaisesTheAlarm) {
  if (!is_installed("prometheus")) GTEST_SKIP() << "prometheus is not installed";
  RunningReporter reporter("scraped");
  auto rules = read_text_file(source_folder() / "systemd/report/kasumi.rules.yml").value();
  rules = changed(rules, "expr: kasumi_picture_well == 0\n        for: 1m",
                  "expr: kasumi_picture_well == 0\n        for: 1s");
  const int port = free_port();
  ASSERT_TRUE(write_text_file(reporter.folder / "kasumi.rules.yml", rules));
  ASSERT_TRUE(write_text_file(
      reporter.folder / "prometheus.yml",
      fmt::format("global: {{scrape_interval: 500ms, scrape_timeout: 500ms, evaluation_interval: 500ms}}\n"
                  "rule_files: [kasumi.rules.yml]\n"
                  "scrape_configs: [{{job_name: kasumi, static_configs: [{{targets: ['127.0.0.1:{}']}}]}}]\n",
                  reporter.port)));
  const Child prometheus({"prometheus", "--config.file=" + (reporter.folder / "prometheus.yml").string(),
                          "--storage.tsdb.path=" + (reporter.folder / "data").string(),
                          fmt::format("--web.listen-address=127.0.0.1:{}", port)},
                         reporter.folder / "prometheus.log");
  const auto asked = [&](const std::string& path) {
    const auto fd = connected(port);
    if (!fd || !sent(fd, fmt::format("GET {} HTTP/1.0\r\nHost: localhost\r\n\r\n", path))) return std::string();
    return heard_from(fd);
  };
  int count = 0;
  const auto alive = [&] {  // as an appliance that writes each second
    reporter.tell(changed(kGoodStatus, "\"pictures\": 9000", fmt::format("\"pictures\": {}", 9000 + ++count)));
  };
  EXPECT_TRUE(within(60, [&] {
    alive();
    return asked("/api/v1/query?query=kasumi_turbidity").find("\"2.41\"") != std::string::npos;
  })) << read_text_file(reporter.folder / "prometheus.log").value_or("");
  EXPECT_THAT(asked("/api/v1/alerts"), Not(HasSubstr("KasumiPictureGone")));
  EXPECT_TRUE(within(60, [&] {
    reporter.tell(changed(changed(kGoodStatus, "\"live\", \"reason\": \"\"",
                                  "\"still\", \"reason\": \"no picture from the scene camera\""),
                          "\"pictures\": 9000", fmt::format("\"pictures\": {}", ++count)));
    const auto alerts = asked("/api/v1/alerts");
    return alerts.find("KasumiPictureGone") != std::string::npos && alerts.find("\"firing\"") != std::string::npos;
  })) << asked("/api/v1/alerts");
}

TEST(Metrics, GoToNodeExportersFolderWithoutAPort) {
  const auto folder = report_folder("textfile");
  ASSERT_TRUE(write_text_file(folder / "status.json", kGoodStatus));
  ASSERT_TRUE(write_text_file(
      folder / "report.toml",
      fmt::format("[kiosk]\nstatus = \"{0}/status.json\"\n[textfile]\nfile = \"{0}/kasumi.prom\"\n", folder.string())));
  Child child({report_program(), "run", "--config", folder / "report.toml"}, folder / "log");
  EXPECT_TRUE(within(20, [&] {
    return read_text_file(folder / "kasumi.prom").value_or("").find("kasumi_turbidity 2.41\n") != std::string::npos;
  })) << read_text_file(folder / "log").value_or("");
  EXPECT_EQ(child.stop(), 0);
}

}  // namespace
}  // namespace kasumi::report
