#include "report/channels/mqtt_channel.hpp"

#include <atomic>
#include <future>
#include <set>
#include <thread>
#include <utility>

#include "base/latest_slot.hpp"
#include "report/diagnosis/diagnosis.hpp"

namespace kasumi::report {

namespace {

using namespace std::chrono_literals;
using Steady = std::chrono::steady_clock;

constexpr auto kLoop = 200ms;           // how soon a new state, or the end, is noticed
constexpr auto kFarewell = 2s;          // for saying that the reporter goes
constexpr std::size_t kMostCauses = 8;  // of one outage
constexpr int kThrownOff = 3;           // times in a row
constexpr auto kStop = 3s;              // for the thread's end; one that hangs in a name's look-up is left behind

// To our greeting.
std::string refusal(int answer, const MqttOptions& options) {
  constexpr int kBadPassword = 4, kNotAllowed = 5;
  constexpr std::string_view kWords[] = {"", "it speaks another version of MQTT", "it does not take our name",
                                         "it is not available"};
  if (answer != kBadPassword && answer != kNotAllowed)
    return fmt::format("it refuses us: {}", answer > 0 && answer < kBadPassword ? kWords[answer] : "it says no reason");
  if (options.user.empty()) return "it asks for a user and a password: mqtt.user, mqtt.password_file";
  return fmt::format("it refuses the user \"{}\": wrong user or password (mqtt.user, mqtt.password_file)",
                     options.user);
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
    for (int thrown_off = 0; !stopped_;) {
      const auto began = Steady::now();
      const bool welcome = converse();
      connected_ = false;
      const auto lasted = Steady::now() - began;
      if (lasted > patience_.settled) {
        wait = patience_.first_wait;
        problems_.clear();
      }
      // Two with one name throw each other off: whoever comes ends the other's connection.
      thrown_off = welcome && lasted <= patience_.settled ? thrown_off + 1 : 0;
      if (thrown_off >= kThrownOff) tell_of_another();
      disputed_ = thrown_off >= kThrownOff;
      const auto pause = disputed_ ? patience_.longest_wait : wait;
      for (const auto end = Steady::now() + pause; !stopped_ && Steady::now() < end;)
        std::this_thread::sleep_for(std::min<Duration>(kLoop, patience_.first_wait));
      wait = std::min(wait * 2, patience_.longest_wait);
    }
  }

 private:
  // true: the broker had welcomed us, and ended the connection all the same.
  bool converse() {
    MqttLink link(options_, identity(), {options_.topic + std::string(kAvailableTopic), std::string(kOffline)});
    auto heard_at = Steady::now();
    std::optional<Steady::time_point> leaving, greeted_at;
    std::optional<std::string> state = last_;
    while (true) {
      const auto unconfirmed = link.unconfirmed();
      const auto turned = link.turn(kLoop);
      const auto now = Steady::now();
      if (link.answer().value_or(0) != 0) return tell_once(refusal(*link.answer(), options_));
      if (!turned && !leaving) tell_once(turned.error().message);
      if (!turned) return greeted_at && !leaving && turned.error().kind == FaultKind::disconnected;
      if (link.unconfirmed() < unconfirmed || (link.answer() && link.unconfirmed() == 0)) heard_at = now;
      if (now - heard_at > patience_.silence) return leaving ? false : tell_once("it does not answer");
      if (!link.answer() && stopped_) return false;
      if (!link.answer()) continue;
      if (!greeted_at) {
        greeted_at = now;
        connected_ = true;
        if (!disputed_) tell_that_it_works();
        greet(link);
        if (!options_.discovery.empty()) link.listen_for_birth(options_.discovery);
      } else if (link.take_birth() && now - *greeted_at > patience_.birth_pause) {
        greeted_at = now;
        greet(link);
        state = last_;
      }
      if (auto newer = states_.take()) state = last_ = std::move(newer);
      // One after the other: a broker that is slow to confirm gets the newest, not all.
      if (state && link.unconfirmed() == 0) {
        link.publish({options_.topic + std::string(kStateTopic), *state}, true);
        state.reset();
      }
      if (stopped_ && !leaving) {
        leaving = now + kFarewell;
        link.publish({options_.topic + std::string(kAvailableTopic), std::string(kOffline)}, true);
      }
      if (!leaving || (link.unconfirmed() > 0 && now <= *leaving)) continue;
      link.say_goodbye();
      (void)link.turn({});
      return false;
    }
  }

  void greet(MqttLink& link) const {
    for (const auto& message : greeting_) link.publish(message, true);
    link.publish({options_.topic + std::string(kAvailableTopic), std::string(kOnline)}, true);
  }

  // The same for every connection of this kiosk, so that a broker ends one that only seems to live.
  std::string identity() const { return "kasumi-report:" + options_.topic; }

  // The log has one line for each cause of an outage, however often it is tried and however they alternate.
  bool tell_once(const std::string& problem) {
    if (disputed_ || problems_.size() >= kMostCauses || !problems_.insert(problem).second) return false;
    fmt::print(stderr, "<4>mqtt: {} port {}: {}\n", options_.host, options_.port, problem);
    return false;
  }
  void tell_of_another() {
    if (std::exchange(another_told_, true)) return;
    fmt::print(
        stderr,
        "<4>mqtt: {} port {}: each connection ends within seconds: another client uses the topic {}, and each throws "
        "the other off (give each kiosk a topic of its own, mqtt.topic), or the broker ends them by itself. It is "
        "tried "
        "again every {:.0f} s\n",
        options_.host, options_.port, options_.topic, to_seconds(patience_.longest_wait));
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
  bool disputed_ = false, another_told_ = false;
};

Result<> publish_once(const MqttOptions& options, std::string_view below, std::string_view payload, Duration longest) {
  MqttLink link(options, {}, {});  // by a name of its own: the kiosk's may be connected
  bool sent = false;
  for (const auto end = Steady::now() + longest; Steady::now() < end;) {
    const auto turned = link.turn(kLoop);
    if (link.answer().value_or(0) != 0) return fail(FaultKind::io, "{}", refusal(*link.answer(), options));
    if (!turned) return turned;
    if (!link.answer()) continue;
    if (sent && link.unconfirmed() == 0) {
      link.say_goodbye();
      (void)link.turn({});  // a broker that hears it closes at once, which is no failure
      return {};
    }
    if (!std::exchange(sent, true)) link.publish({options.topic + std::string(below), std::string(payload)}, false);
  }
  return fail(FaultKind::io, "no answer within {:.0f} s", to_seconds(longest));
}

MqttChannel::MqttChannel(MqttOptions options, const std::string& name, Language language, Clock& clock,
                         MqttPatience patience)
    : language_(language), every_(options.every), clock_(clock) {
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
