// A real mosquitto on a port of its own, and whoever listens to it.
#pragma once

#include "tests/report/running_reporter.hpp"

namespace kasumi::report {

constexpr const char* kMosquitto = "/usr/sbin/mosquitto";

inline bool has_mosquitto() {
  return is_installed(kMosquitto) && is_installed("mosquitto_sub");
}

class MqttBroker {
 public:
  // `more`: of mosquitto.conf, below the listener.
  explicit MqttBroker(std::filesystem::path broker_folder, const std::string& more = "allow_anonymous true",
                      int broker_port = free_port())
      : folder(std::move(broker_folder)), port(broker_port) {
    // It gives up root's rights for those of a user who may not read the test's folder.
    EXPECT_TRUE(
        write_text_file(folder / "mosquitto.conf", fmt::format("user root\nlistener {} 127.0.0.1\n{}\n", port, more)));
    start();
  }
  void start() {
    child_.emplace(std::vector<std::string>{kMosquitto, "-c", folder / "mosquitto.conf"}, folder / "mosquitto.log");
    EXPECT_TRUE(within(20, [&] { return bool(connected(port)); }))
        << read_text_file(folder / "mosquitto.log").value_or("");
  }
  void stop() { child_.reset(); }
  // What a subscriber who comes now hears of a topic within some seconds; empty: nothing.
  std::string retained(const std::string& topic, int seconds = 3, const std::string& options = {}) const {
    auto text =
        said_by(fmt::format("mosquitto_sub -h 127.0.0.1 -p {} {} -C 1 -W {} -t '{}'", port, options, seconds, topic));
    while (text.ends_with('\n')) text.pop_back();
    return text.starts_with("Timed out") ? "" : text;
  }

  const std::filesystem::path folder;
  const int port;

 private:
  std::optional<Child> child_;
};

}  // namespace kasumi::report
