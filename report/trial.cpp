#include "report/trial.hpp"

#include <thread>

#include "base/utc_text.hpp"
#include "report/channels/sendmail.hpp"
#include "report/web/web_request.hpp"

namespace kasumi::report {

namespace {

using namespace std::chrono_literals;

constexpr Duration kLongestTrial = 20s;        // of one channel, but for mail
constexpr Duration kPauseBetweenLooks = 50ms;  // below what a person notices

Result<std::string> try_mail(const MailOptions& mail, const ReportConfig& config, const Heard& heard, Clock& clock) {
  auto sendmail =
      Sendmail::start(mail.command, trial_mail(mail, config.name, config.language, diagnose(heard).sight), clock);
  if (!sendmail) return fail(sendmail.error());
  for (;; std::this_thread::sleep_for(kPauseBetweenLooks)) {
    const auto done = sendmail->turn();
    if (!done) continue;
    if (!*done) return fail(done->error());
    return fmt::format("{} has taken a mail to {}: look whether it arrives", mail.command[0], fmt::join(mail.to, ", "));
  }
}

Result<std::string> try_mqtt(const MqttOptions& mqtt, Clock& clock) {
  // Below the kiosk's own, so that no reader takes it for a state.
  constexpr std::string_view kTrialTopic = "/trial";
  const auto text =
      fmt::format("{{\"trial_utc\":\"{}\"}}", utc_text(std::chrono::floor<std::chrono::seconds>(clock.utc())));
  const auto taken = publish_once(mqtt, kTrialTopic, text, kLongestTrial);
  if (!taken) return fail(FaultKind::io, "{} port {}: {}", mqtt.host, mqtt.port, taken.error().message);
  return fmt::format("{} port {} has taken a message on {}{}", mqtt.host, mqtt.port, mqtt.topic, kTrialTopic);
}

// A server's answer to a request whose body does not matter.
Result<long> answer_of(const std::string& url, const std::string& ca_file, const char* protocols, bool body) {
  WebRequest request(url, ca_file, protocols, kLongestTrial / 2);
  request.set(CURLOPT_NOBODY, body ? 0L : 1L);
  request.set(CURLOPT_TIMEOUT_MS, static_cast<long>(kLongestTrial / 1ms));
  const curl_write_callback discard = [](char*, std::size_t, std::size_t bytes, void*) { return bytes; };
  request.set(CURLOPT_WRITEFUNCTION, discard);
  for (;; std::this_thread::sleep_for(kPauseBetweenLooks)) {
    const auto end = request.turn();
    if (!end) continue;
    if (!end->problem.empty()) return fail(FaultKind::io, "{}: {}", host_of(url), end->problem);
    if (end->code < 200 || end->code >= 300) return fail(FaultKind::io, "{}: it answers {}", host_of(url), end->code);
    return end->code;
  }
}

Result<std::string> try_sign_of_life(const SignOfLifeOptions& sign, const Heard& heard) {
  if (!is_well(diagnose(heard).sight)) return "not tried, since it would say that visitors see the building";
  const auto answer = answer_of(sign.url, sign.ca_file, "http,https", true);
  if (!answer) return fail(answer.error());
  return fmt::format("{} has taken a sign of life", host_of(sign.url));
}

Result<std::string> try_content(const PullOptions& content) {
  const auto answer = answer_of(content.url, content.ca_file, "https", false);
  if (!answer) return fail(answer.error());
  return fmt::format("{} has the bundle", host_of(content.url));
}

}  // namespace

std::vector<Trial> try_channels(const ReportConfig& config, const Heard& heard, Clock& clock) {
  std::vector<Trial> trials;
  if (config.mail) trials.push_back({"mail", try_mail(*config.mail, config, heard, clock)});
  if (config.mqtt) trials.push_back({"mqtt", try_mqtt(*config.mqtt, clock)});
  if (config.sign_of_life) trials.push_back({"sign_of_life", try_sign_of_life(*config.sign_of_life, heard)});
  if (config.content) trials.push_back({"content", try_content(*config.content)});
  return trials;
}

}  // namespace kasumi::report
