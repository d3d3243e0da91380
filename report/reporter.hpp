// The reporter: reads the kiosk's status once a second and reports it over every configured channel.
#pragma once

#include <atomic>
#include <memory>
#include <optional>

#include "history/history_line.hpp"
#include "report/channels/mail_channel.hpp"
#include "report/channels/metrics.hpp"
#include "report/channels/mqtt_channel.hpp"
#include "report/channels/sign_of_life.hpp"
#include "report/page/http_server.hpp"
#include "report/page/screen_asking.hpp"
#include "report/report_config.hpp"
#include "report/web/content_pull.hpp"

namespace kasumi::report {

class Reporter {
 public:
  // Errors (bad_input): an address or port that cannot be listened at.
  static Result<std::unique_ptr<Reporter>> start(ReportConfig config, Clock& clock);

  // BLOCKS for at most a quarter of a second.
  void turn();
  const Heard& heard() const { return heard_; }
  // Where a port 0 ended up; 0: no port is open.
  int port() const { return server_ ? server_->port() : 0; }
  std::string line() const;  // for `systemctl status`
  // Tries every channel in the background and logs each result. One trial at a time.
  void begin_trial();

 private:
  Reporter(ReportConfig config, Clock& clock);
  void look();
  Answer answer(const Request& request);
  Answer answer_admitted(const Request& request);
  std::string metrics() const;
  Answer page(const Request& request);
  void write_textfile();

  ReportConfig config_;
  Clock& clock_;
  StatusWatch watch_;
  Heard heard_;
  Tokens tokens_;
  std::map<std::string, std::uint64_t> turned_away_;  // by why
  std::vector<HistoryLine> history_;                  // as it was read last
  std::optional<Instant> history_at_;
  std::optional<ScreenAsking> screen_;  // where it may be asked for
  std::string form_key_;                // changes with each start
  std::optional<HttpServer> server_;
  std::unique_ptr<MqttChannel> mqtt_;
  std::unique_ptr<MailChannel> mail_;
  std::unique_ptr<SignOfLife> sign_of_life_;
  std::unique_ptr<ContentPull> content_;
  std::optional<Instant> looked_at_, textfile_at_;
  bool textfile_failing_ = false;
  std::shared_ptr<std::atomic<bool>> trying_ = std::make_shared<std::atomic<bool>>(false);
};

}  // namespace kasumi::report
