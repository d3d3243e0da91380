#include "report/reporter.hpp"

#include <ctime>
#include <thread>

#include "base/files.hpp"
#include "history/history_ring.hpp"
#include "report/page/own_name.hpp"
#include "report/page/state_page.hpp"
#include "report/trial.hpp"

namespace kasumi::report {

namespace {

using namespace std::chrono_literals;

constexpr Duration kLook = 1s;       // as often as the status is written
constexpr Duration kTurn = 250ms;    // bounds how late a request is answered while nothing else comes
constexpr Duration kHistory = 20s;   // a line is added each minute
constexpr Duration kTextfile = 15s;  // node_exporter is scraped about as often

std::chrono::minutes ahead_of_utc() {
  const auto now = std::time(nullptr);
  std::tm wall{};
  ::localtime_r(&now, &wall);
  return std::chrono::minutes{wall.tm_gmtoff / 60};
}

}  // namespace

Reporter::Reporter(ReportConfig config, Clock& clock)
    : config_(std::move(config)),
      clock_(clock),
      watch_(config_.status, clock),
      tokens_(config_.http ? config_.http->tokens : std::vector<AccessToken>(), clock) {}

Result<std::unique_ptr<Reporter>> Reporter::start(ReportConfig config, Clock& clock) {
  std::unique_ptr<Reporter> reporter(new Reporter(std::move(config), clock));
  if (const auto& http = reporter->config_.http) {
    if (http->screen_picture) {
      auto key = random_letters();
      if (!key) return fail(key.error());
      reporter->form_key_ = std::move(*key);
      reporter->screen_.emplace(screen_socket(reporter->config_.status.parent_path()), clock);
    }
    auto server = HttpServer::listen(http->address, http->port, clock,
                                     [of = reporter.get()](const Request& request) { return of->answer(request); });
    if (!server) return fail(server.error());
    reporter->server_ = std::move(*server);
  }
  if (const auto& mqtt = reporter->config_.mqtt)
    reporter->mqtt_ = std::make_unique<MqttChannel>(*mqtt, reporter->config_.name, reporter->config_.language, clock);
  if (const auto& mail = reporter->config_.mail)
    reporter->mail_ = std::make_unique<MailChannel>(*mail, reporter->config_.name, reporter->config_.language, clock);
  if (const auto& sign = reporter->config_.sign_of_life)
    reporter->sign_of_life_ = std::make_unique<SignOfLife>(*sign, clock);
  if (const auto& content = reporter->config_.content)
    reporter->content_ = std::make_unique<ContentPull>(*content, clock);
  reporter->look();
  return reporter;
}

void Reporter::turn() {
  if (server_)
    server_->turn(kTurn);
  else
    std::this_thread::sleep_for(kTurn);
  if (sign_of_life_) sign_of_life_->turn();
  if (content_) content_->turn();
  const auto now = clock_.now();
  if (!looked_at_ || now - *looked_at_ >= kLook) look();
}

void Reporter::look() {
  looked_at_ = clock_.now();
  heard_ = watch_.look();
  if (mqtt_) mqtt_->tell(heard_);
  if (mail_) mail_->tell(heard_);
  if (sign_of_life_) sign_of_life_->tell(heard_);
  if (config_.textfile && (!textfile_at_ || *looked_at_ - *textfile_at_ >= kTextfile)) write_textfile();
}

void Reporter::write_textfile() {
  textfile_at_ = clock_.now();
  const auto written = write_text_file(config_.textfile->file, metrics());
  if (!written && !textfile_failing_) fmt::print(stderr, "<4>textfile: {}\n", written.error().message);
  textfile_failing_ = !written;
}

std::string Reporter::metrics() const {
  OwnFigures own;
  own.resident_bytes = own_resident_bytes();
  if (server_) {
    own.answered = server_->answered();
    own.refused = server_->refused();
  }
  if (mail_) own.mails = OwnFigures::Tries{mail_->sent(), mail_->failed()};
  if (sign_of_life_) own.signs_of_life = OwnFigures::Tries{sign_of_life_->given(), sign_of_life_->failed()};
  if (content_) own.pulls = OwnFigures::Pulls{content_->fetched(), content_->unchanged(), content_->failed()};
  if (mqtt_) own.mqtt_connected = mqtt_->connected();
  for (const auto& [why, count] : turned_away_) own.refused[why] += count;
  return metrics_text(heard_, disk_figures(config_.state), own);
}

Answer Reporter::answer(const Request& request) {
  if (!tokens_.empty()) {
    const auto admission = tokens_.admit(request.authorization, request.address);
    if (admission == Admission::admitted) return answer_admitted(request);
    ++turned_away_[std::string(name_of(admission))];
    if (admission == Admission::too_many) {
      auto later = plain_answer(429, "Too many guesses. Try again in a second.\n");
      later.headers = {{"Retry-After", "1"}};
      return later;
    }
    auto refusal = plain_answer(401, fmt::format("Expected a token: {}.\n", name_of(admission)));
    refusal.headers = {{"WWW-Authenticate",
                        "Basic realm=\"Kasumi: leave the name empty, the password is the token\", charset=\"UTF-8\""}};
    return refusal;
  }
  if (!is_own_name(request.host, config_.http->names)) {
    ++turned_away_["foreign name"];
    return plain_answer(421, "This is not the host you asked for.\n");
  }
  return answer_admitted(request);
}

Answer Reporter::answer_admitted(const Request& request) {
  const bool shows_screen = screen_ && request.path == "/screen";
  if (request.posts && !shows_screen) return only_reading();
  // A foreign page can make a browser send a form, but cannot read this page.
  if (request.posts && request.key != form_key_)
    return plain_answer(403, "This button is of an earlier page: load the page again.\n");
  if (request.path == "/metrics") {
    auto answer = plain_answer(200, metrics());
    answer.type = "text/plain; version=0.0.4; charset=utf-8";
    return answer;
  }
  if (request.path == "/" || shows_screen) return page(request);
  if (request.path == "/style.css")
    return {200, "text/css; charset=utf-8", std::make_shared<const std::string>(page_style()), {}};
  return plain_answer(404, "There is nothing here.\n");
}

Answer Reporter::page(const Request& request) {
  const auto now = clock_.now();
  if (!history_at_ || now - *history_at_ >= kHistory) {
    history_at_ = now;
    const auto text = read_distrusted_file(config_.state / kHistoryFile, kHistoryBytes);
    history_ = text ? history_lines(*text) : std::vector<HistoryLine>();
    // What is drawn is the last day.
    constexpr std::size_t kKept = 2 * 24 * 60;
    if (history_.size() > kKept) history_.erase(history_.begin(), history_.end() - kKept);
    history_.shrink_to_fit();
  }
  const auto language = wanted_language(request.language, request.accept_language, config_.language);
  StatePage of{config_.name, heard_, history_, clock_.utc(), ahead_of_utc()};
  if (content_) of.pull = content_->status();
  if (screen_) of.screen = ScreenPart{form_key_, request.posts ? std::optional(screen_->ask()) : std::nullopt};
  auto html = state_page(of, language);
  return {200,
          "text/html; charset=utf-8",
          std::make_shared<const std::string>(std::move(html)),
          {{"Vary", "Accept-Language"}}};
}

void Reporter::begin_trial() {
  if (trying_->exchange(true)) return;
  // Left behind where the reporter ends before it: it may wait for a server.
  std::thread([config = config_, heard = heard_, trying = trying_] {
    SystemClock clock;
    for (const auto& trial : try_channels(config, heard, clock))
      fmt::print(stderr, "<{}>trial: {}: {}\n", trial.came ? 5 : 4, trial.channel,
                 trial.came ? *trial.came : trial.came.error().message);
    *trying = false;
  }).detach();
}

std::string Reporter::line() const {
  return fmt::format("visitors: {}", name_of(diagnose(heard_).sight));
}

}  // namespace kasumi::report
