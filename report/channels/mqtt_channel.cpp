#include "report/channels/mqtt_channel.hpp"

#include <atomic>
#include <cerrno>
#include <cstring>
#include <future>
#include <set>
#include <thread>

#include <mosquitto.h>

#include "base/c_ptr.hpp"
#include "base/latest_slot.hpp"
#include "report/status/diagnosis.hpp"

namespace kasumi::report {

namespace {

using namespace std::chrono_literals;
using Steady = std::chrono::steady_clock;

constexpr auto kLoop = 200ms;           // how soon a new state, or the end, is noticed
constexpr auto kFarewell = 2s;          // for saying that the reporter goes
constexpr std::size_t kMostCauses = 8;  // of one outage
constexpr auto kStop = 3s;              // for the thread's end; one that hangs in a name's look-up is left behind
constexpr auto kSettled = 60s;          // a connection that lasted so long ends the doubling of waits
constexpr int kKeepalive_s = 30;        // the broker tells the last will after one and a half of it
constexpr int kAtLeastOnce = 1;

using Client = CPtr<mosquitto, mosquitto_destroy>;

void prepare_library() {
  static const int ready = mosquitto_lib_init();  // never undone: a thread may be left behind
  (void)ready;
}

// Who we are, and whom we trust.
int introduce(mosquitto& client, const MqttOptions& options) {
  int rc = MOSQ_ERR_SUCCESS;
  if (!options.user.empty()) rc = mosquitto_username_pw_set(&client, options.user.c_str(), options.password.c_str());
  if (rc != MOSQ_ERR_SUCCESS || !options.tls) return rc;
  const auto file = [](const std::string& name) { return name.empty() ? nullptr : name.c_str(); };
  // A key with a password is refused: OpenSSL would ask for it at a terminal.
  const auto no_password = [](char*, int, int, void*) { return 0; };
  return mosquitto_tls_set(&client, file(options.ca_file), options.ca_file.empty() ? "/etc/ssl/certs" : nullptr,
                           file(options.cert_file), file(options.key_file), no_password);
}

std::string why(int rc, const std::string& library_said) {
  if (rc == MOSQ_ERR_ERRNO) return std::strerror(errno);
  std::string text = mosquitto_strerror(rc);
  if (!library_said.empty()) text += fmt::format(" ({})", library_said);
  return text;
}

// To our greeting.
std::string refusal(int answer, const MqttOptions& options) {
  constexpr int kBadPassword = 4, kNotAllowed = 5;
  if (answer != kBadPassword && answer != kNotAllowed)
    return fmt::format("it refuses us: {}", mosquitto_connack_string(answer));
  if (options.user.empty()) return "it asks for a user and a password: mqtt.user, mqtt.password_file";
  return fmt::format("it refuses the user \"{}\": wrong user or password (mqtt.user, mqtt.password_file)",
                     options.user);
}

// One connection, from beginning to end.
struct Conversation {
  std::optional<int> answer;  // of the broker to our greeting
  int unconfirmed = 0;        // messages
  std::string library_said;   // its last complaint
};

void listen_to(mosquitto& client) {
  mosquitto_connect_callback_set(
      &client, [](mosquitto*, void* now, int answer) { static_cast<Conversation*>(now)->answer = answer; });
  mosquitto_publish_callback_set(&client,
                                 [](mosquitto*, void* now, int) { --static_cast<Conversation*>(now)->unconfirmed; });
  mosquitto_log_callback_set(&client, [](mosquitto*, void* now, int level, const char* text) {
    if (level == MOSQ_LOG_ERR && text) static_cast<Conversation*>(now)->library_said = text;
  });
}

}  // namespace

// Shared with the thread, which may outlive the channel by the time of a name's look-up.
class MqttChannel::Talk {
 public:
  Talk(MqttOptions options, std::vector<MqttMessage> greeting, MqttPatience patience)
      : options_(std::move(options)), greeting_(std::move(greeting)), patience_(patience) {}

  void put(std::string state) { states_.put(std::move(state)); }
  bool connected() const { return connected_; }
  void stop() { stopped_ = true; }

  void live() {
    auto wait = patience_.first_wait;
    while (!stopped_) {
      const auto began = Steady::now();
      converse();
      connected_ = false;
      if (Steady::now() - began > kSettled) wait = patience_.first_wait;
      for (const auto end = Steady::now() + wait; !stopped_ && Steady::now() < end;) std::this_thread::sleep_for(kLoop);
      wait = std::min(wait * 2, patience_.longest_wait);
    }
  }

 private:
  void converse() {
    Conversation now;
    const Client client(mosquitto_new(identity().c_str(), true, &now));
    if (!client) return tell_once("no memory");
    const auto begun = prepare(*client);
    if (begun != MOSQ_ERR_SUCCESS) return tell_once(why(begun, now.library_said));
    auto heard_at = Steady::now();
    std::optional<Steady::time_point> leaving;
    std::optional<std::string> state = last_;
    bool greeted = false;
    while (true) {
      const int unconfirmed = now.unconfirmed;
      const int rc = mosquitto_loop(client.get(), static_cast<int>(std::chrono::milliseconds(kLoop).count()), 1);
      if (now.answer && *now.answer != 0) return tell_once(refusal(*now.answer, options_));
      if (rc != MOSQ_ERR_SUCCESS) return leaving ? void() : tell_once(why(rc, now.library_said));
      if (now.unconfirmed < unconfirmed || (now.answer && now.unconfirmed == 0)) heard_at = Steady::now();
      if (Steady::now() - heard_at > patience_.silence) return leaving ? void() : tell_once("it does not answer");
      if (!now.answer) {
        if (stopped_) return;
        continue;
      }
      if (!greeted) {
        greeted = true;
        connected_ = true;
        tell_that_it_works();
        for (const auto& message : greeting_) publish(*client, now, message.topic, message.payload);
        publish(*client, now, options_.topic + std::string(kAvailableTopic), kOnline);
      }
      if (auto newer = states_.take()) state = last_ = std::move(newer);
      // One after the other: a broker that is slow to confirm gets the newest, not all.
      if (state && now.unconfirmed == 0) {
        publish(*client, now, options_.topic + std::string(kStateTopic), *state);
        state.reset();
      }
      if (stopped_ && !leaving) {
        leaving = Steady::now() + kFarewell;
        publish(*client, now, options_.topic + std::string(kAvailableTopic), kOffline);
      }
      if (leaving && (now.unconfirmed == 0 || Steady::now() > *leaving)) {
        mosquitto_disconnect(client.get());
        return;
      }
    }
  }

  int prepare(mosquitto& client) {
    listen_to(client);
    const auto available = options_.topic + std::string(kAvailableTopic);
    int rc = mosquitto_will_set(&client, available.c_str(), static_cast<int>(kOffline.size()), kOffline.data(),
                                kAtLeastOnce, true);
    if (rc == MOSQ_ERR_SUCCESS) rc = introduce(client, options_);
    if (rc != MOSQ_ERR_SUCCESS) return rc;
    return mosquitto_connect_async(&client, options_.host.c_str(), options_.port, kKeepalive_s);
  }

  void publish(mosquitto& client, Conversation& now, const std::string& topic, std::string_view payload) {
    const int rc = mosquitto_publish(&client, nullptr, topic.c_str(), static_cast<int>(payload.size()), payload.data(),
                                     kAtLeastOnce, true);
    if (rc == MOSQ_ERR_SUCCESS) ++now.unconfirmed;
  }

  // The same for every connection of this kiosk, so that a broker ends one that only seems to live.
  std::string identity() const { return "kasumi-report:" + options_.topic; }

  // The log has one line for each cause of an outage, however often it is tried and however they alternate.
  void tell_once(const std::string& problem) {
    if (problems_.size() >= kMostCauses || !problems_.insert(problem).second) return;
    fmt::print(stderr, "<4>mqtt: {} port {}: {}\n", options_.host, options_.port, problem);
  }
  void tell_that_it_works() {
    if (!std::exchange(problems_, {}).empty())
      fmt::print(stderr, "<5>mqtt: {} port {}: connected\n", options_.host, options_.port);
  }

  const MqttOptions options_;
  const std::vector<MqttMessage> greeting_;
  const MqttPatience patience_;
  LatestSlot<std::string> states_;
  std::atomic<bool> connected_ = false, stopped_ = false;
  // The thread's own.
  std::optional<std::string> last_;  // state
  std::set<std::string> problems_;   // told in this outage
};

Result<> publish_once(const MqttOptions& options, std::string_view below, std::string_view payload, Duration longest) {
  prepare_library();
  Conversation now;
  const Client client(mosquitto_new(nullptr, true, &now));  // by a name of its own: the kiosk's may be connected
  if (!client) return fail(FaultKind::io, "no memory");
  listen_to(*client);
  int rc = introduce(*client, options);
  if (rc == MOSQ_ERR_SUCCESS)
    rc = mosquitto_connect_async(client.get(), options.host.c_str(), options.port, kKeepalive_s);
  if (rc != MOSQ_ERR_SUCCESS) return fail(FaultKind::io, "{}", why(rc, now.library_said));
  const auto topic = options.topic + std::string(below);
  bool sent = false;
  for (const auto end = Steady::now() + longest; Steady::now() < end;) {
    rc = mosquitto_loop(client.get(), static_cast<int>(std::chrono::milliseconds(kLoop).count()), 1);
    if (now.answer && *now.answer != 0) return fail(FaultKind::io, "{}", refusal(*now.answer, options));
    if (rc != MOSQ_ERR_SUCCESS) return fail(FaultKind::io, "{}", why(rc, now.library_said));
    if (!now.answer) continue;
    if (sent && now.unconfirmed == 0) {
      mosquitto_disconnect(client.get());
      return {};
    }
    if (sent) continue;
    sent = true;
    rc = mosquitto_publish(client.get(), nullptr, topic.c_str(), static_cast<int>(payload.size()), payload.data(),
                           kAtLeastOnce, false);
    if (rc != MOSQ_ERR_SUCCESS) return fail(FaultKind::io, "{}", why(rc, now.library_said));
    ++now.unconfirmed;
  }
  return fail(FaultKind::io, "no answer within {:.0f} s", to_seconds(longest));
}

MqttChannel::MqttChannel(MqttOptions options, const std::string& name, Language language, Clock& clock,
                         MqttPatience patience)
    : language_(language), every_(options.every), clock_(clock) {
  prepare_library();
  auto greeting = options.discovery.empty() ? std::vector<MqttMessage>()
                                            : discovery_messages(options.discovery, options.topic, name, language);
  talk_ = std::make_shared<Talk>(std::move(options), std::move(greeting), patience);
  std::packaged_task<void()> task([talk = talk_] { talk->live(); });
  ended_ = task.get_future();
  thread_ = std::thread(std::move(task));
}

MqttChannel::~MqttChannel() {
  talk_->stop();
  if (ended_.wait_for(kStop) == std::future_status::ready)
    thread_.join();
  else
    thread_.detach();
}

void MqttChannel::tell(const Heard& heard) {
  const auto diagnosis = diagnose(heard);
  std::string news(name_of(diagnosis.sight));
  for (const auto& symptom : diagnosis.symptoms) news += fmt::format(" {}", name_of(symptom.ill));
  const auto now = clock_.now();
  if (told_at_ && news == told_ && now - *told_at_ < every_) return;
  told_ = std::move(news);
  told_at_ = now;
  talk_->put(mqtt_state(heard, language_));
}

bool MqttChannel::connected() const {
  return talk_->connected();
}

}  // namespace kasumi::report
