// All that kasumi-report reads: a peer's request, report.toml, the kiosk's history, what it remembers of its mails and of
// content that arrives, what a web server answers about that, what the kiosk's socket says of its screen, and (any other input)
// status.json. What it then tells must hold together, whatever it was told.
#include <string_view>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "base/unique_fd.hpp"
#include "base/utc_text.hpp"
#include "history/history_ring.hpp"
#include "report/channels/mail_text.hpp"
#include "report/channels/metrics.hpp"
#include "report/channels/mqtt_messages.hpp"
#include "report/page/http_server.hpp"
#include "report/page/own_name.hpp"
#include "report/page/state_page.hpp"
#include "report/report_config.hpp"
#include "report/show.hpp"
#include "report/web/pull_answer.hpp"
#include "tests/fuzz/scratch.hpp"

namespace {

using namespace kasumi;
using namespace kasumi::report;
using namespace std::chrono_literals;

const Utc kNow = *parse_utc("2026-06-21T12:00:00Z");

void expect(bool holds) {
  if (!holds) std::abort();
}

StatePage page_of(Heard heard, std::vector<HistoryLine> history) {
  return {"Hill", std::move(heard), std::move(history), kNow, 120min};
}

void expect_page(const std::string& html) {
  expect(html.starts_with("<!DOCTYPE html>") && html.ends_with("</html>\n"));
  expect(html.find("<script") == std::string::npos);
}

// No line may be longer, no header may begin where the kiosk's words are.
void expect_mail(const std::string& mail) {
  std::size_t length = 0;
  for (const char c : mail) {
    length = c == '\n' ? 0 : length + 1;
    expect(length <= 998 && c != '\r' && c != '\0');
  }
  const auto header = mail.substr(0, mail.find("\n\n") + 1);
  expect(header.find("\nSubject: ") != std::string::npos && header.ends_with("\nContent-Transfer-Encoding: 8bit\n"));
}

void try_status(std::string_view text) {
  Heard heard;
  if (auto status = parse_status(text)) {
    heard.contact = Contact::heard;
    heard.status = std::move(*status);
  } else {
    expect_value_or_sentence(status);
    heard.contact = Contact::unreadable;
    heard.why = status.error().message;
  }
  const auto language = all_languages()[text.size() % all_languages().size()];
  expect_page(state_page(page_of(heard, {}), language));
  expect(!state_text(heard, language).empty());
  const auto metrics = metrics_text(heard, DiskFigures{1e9, 1e10}, {});
  expect(metrics.ends_with('\n') && metrics.find("\n\n") == std::string::npos &&
         metrics.find("nan") == std::string::npos);
  const auto state = mqtt_state(heard, language);
  expect(state.starts_with("{\"sight\":\"") && state.ends_with('}') && state.find('\n') == std::string::npos);
  ManualClock clock(kNow);
  MailWatch watch(15min, {}, clock);
  for (int i = 0; i < 3; ++i) {
    watch.look(heard);
    clock.advance(25h);
  }
  const auto news = watch.due();
  expect(news.has_value() || diagnose(heard).symptoms.empty());
  if (!news) return;
  MailOptions options;
  options.to = {"me@example.org"};
  expect_mail(mail_text(*news, options, heard.why, language, watch.pause()));
  watch.told(*news);
  expect(parse_mail_memory(text_of(watch.memory())) == watch.memory());
}

// The server and who may read, as the reporter puts them together. Nobody waits: what is not served in a few turns is not.
void try_request(std::string_view bytes) {
  static ManualClock clock(kNow);
  static Tokens tokens({{"me", "$y$j75$5w7tWn0bQdjP7H5qDpqGQ/$sJVLlmSUJmEfkQgGCzN1ykchI4bNd8s1UOkdxvCEKQ3", {}}},
                       clock);
  static auto server = HttpServer::listen("127.0.0.1", 0, clock, [](const Request& request) {
    const auto admission = tokens.admit(request.authorization);
    expect(admission != Admission::admitted);
    is_own_name(request.host, {"hill.example.org"});
    return plain_answer(
        200, std::string(code_of(wanted_language(request.language, request.accept_language, Language::english))));
  });
  expect_value_or_sentence(server);
  const UniqueFd peer(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(server->port()));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  expect(::connect(peer.value(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  ::send(peer.value(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  ::shutdown(peer.value(), SHUT_WR);
  char answer[4096];
  for (int i = 0; i < 8; ++i) {
    server->turn(0ms);
    const auto n = ::recv(peer.value(), answer, sizeof answer, MSG_DONTWAIT);
    if (n == 0) break;
    if (n > 0) expect(std::string_view(answer, static_cast<std::size_t>(n)).starts_with("HTTP/1."));
  }
  expect(server->connections() <= 64);
}

void try_config(std::string_view text) {
  const auto root = ConfigTable::parse(text, "report.toml");
  expect_value_or_sentence(root);
  if (!root) return;
  const auto config = read_report_config(*root);
  const auto whole = root->finish();
  expect_value_or_sentence(whole);
  if (!whole) return;
  expect(!config.mqtt || (is_topic(config.mqtt->topic) && !config.mqtt->host.empty()));
  if (!config.mail) return;
  expect(!config.mail->to.empty() && config.mail->command.at(0).starts_with('/'));
  expect_mail(mail_text({}, *config.mail, config.name, config.language, config.mail->pause));
}

// Header lines of a web server: what is believed of them can be sent back in a header, and is of a part that ends well.
void try_answer(std::string_view text) {
  PullAnswer answer;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    take_header(text.substr(0, end), answer);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  expect(answer.code == 0 || (answer.code >= 100 && answer.code <= 999));
  for (const char c : answer.tag) expect(c > 0x20 && c < 0x7f);
  expect(!answer.first || *answer.first < *answer.of_bytes);
}

void try_note(std::string_view text) {
  const auto note = parse_pull_note(text);
  expect(!note || parse_pull_note(text_of(*note)) == note);
}

// What is believed can be said again, is small, and shows nothing but itself on the page.
void try_screen(std::string_view line) {
  auto answer = parse_screen_line(line);
  expect_value_or_sentence(answer);
  if (!answer) return;
  const auto& picture = answer->picture;
  expect(picture.width() <= kMostScreenPixels && picture.height() <= kMostScreenPixels);
  const auto said = screen_answer_bytes(*answer);
  const auto again = parse_screen_line(std::string_view(said).substr(0, said.find('\n')));
  expect(again && again->wait == answer->wait && again->picture.elements() == picture.elements());
  auto page = page_of({}, {});
  const auto outcome = picture.empty() ? ScreenOutcome::wait : ScreenOutcome::picture;
  page.screen = ScreenPart{"key", ScreenReply{outcome, std::move(*answer), {}}};
  expect_page(state_page(page, Language::english));
}

bool take(std::string_view& text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return false;
  text.remove_prefix(prefix.size());
  return true;
}

}  // namespace

void kasumi::try_input(std::span<const std::uint8_t> input) {
  std::string_view text(reinterpret_cast<const char*>(input.data()), input.size());
  if (take(text, "request\n")) return try_request(text);
  if (take(text, "config\n")) return try_config(text);
  if (take(text, "history\n")) return expect_page(state_page(page_of({}, history_lines(text)), Language::english));
  if (take(text, "answer\n")) return try_answer(text);
  if (take(text, "note\n")) return try_note(text);
  if (take(text, "screen\n")) return try_screen(text);
  if (take(text, "memory\n")) {
    const auto memory = parse_mail_memory(text);
    expect(parse_mail_memory(text_of(memory)) == memory);
    ManualClock clock(kNow);
    return expect(MailWatch(15min, memory, clock).pause() <= 16 * 15min);
  }
  try_status(text);
}
