#include "report/channels/mqtt_link.hpp"

#include <algorithm>
#include <array>
#include <thread>
#include <utility>

namespace kasumi::report {

namespace {

using namespace std::chrono_literals;

constexpr auto kConnecting = 20s;  // look-up, connection and TLS
constexpr auto kLook = 20ms;       // between looks while connecting
constexpr int kKeepalive_s = 30;   // the broker tells the last will after one and a half of it
constexpr auto kPing = 20s;        // of silence of our own
// In one go. A broker confirms some sixty messages of discovery with four bytes each; one that never ends would keep us
// reading for ever.
constexpr std::size_t kMostAtOnce = 4096;

// Packets by their first byte, MQTT 3.1.1.
constexpr unsigned char kConnect = 0x10, kConnack = 0x20, kPublish = 0x30, kPuback = 0x40, kSubscribe = 0x82,
                        kSuback = 0x90, kPingreq = 0xc0, kPingresp = 0xd0, kDisconnect = 0xe0;
constexpr unsigned char kAtLeastOnce = 0x02, kRetained = 0x01;  // of a publish packet

std::string number16(unsigned value) {
  return {static_cast<char>(value >> 8 & 0xff), static_cast<char>(value & 0xff)};
}

std::string counted(std::string_view text) {
  return number16(static_cast<unsigned>(text.size())) + std::string(text);
}

unsigned number_at(std::string_view body, std::size_t at) {
  return static_cast<unsigned>(static_cast<unsigned char>(body[at])) << 8 | static_cast<unsigned char>(body[at + 1]);
}

std::string address_of(const MqttOptions& options) {
  const bool six = options.host.find(':') != std::string::npos;
  return fmt::format("{}://{}{}{}:{}", options.tls ? "https" : "http", six ? "[" : "", options.host, six ? "]" : "",
                     options.port);
}

tl::unexpected<Fault> no_mqtt(std::string_view what) {
  return fail(FaultKind::io, "it does not speak MQTT as a broker does: {}", what);
}

}  // namespace

MqttLink::MqttLink(const MqttOptions& options, const std::string& identity, const MqttMessage& will)
    : options_(options),
      identity_(identity),
      will_(will),
      request_(address_of(options), options.ca_file, "http,https", kConnecting),
      said_at_(Steady::now()) {
  request_.set(CURLOPT_CONNECT_ONLY, 1L);
  request_.set(CURLOPT_SSL_ENABLE_ALPN, 0L);
  request_.set(CURLOPT_PROXY, "");
  if (options.cert_file.empty()) return;
  request_.set(CURLOPT_SSLCERT, options.cert_file.c_str());
  request_.set(CURLOPT_SSLKEY, options.key_file.c_str());
  request_.set(CURLOPT_KEYPASSWD, "");  // a key with a password is refused: OpenSSL would ask for it at a terminal
}

Result<> MqttLink::turn(std::chrono::milliseconds longest) {
  const auto until = Steady::now() + longest;
  while (!connected_) {
    if (auto made = connect(); !made) return made;
    if (connected_ || Steady::now() >= until) break;
    std::this_thread::sleep_for(kLook);
  }
  if (!connected_) return {};
  if (answer_ && Steady::now() - said_at_ > kPing) {
    if (pinged_) return fail(FaultKind::io, "it does not answer");
    pinged_ = true;
    put(kPingreq, {});
  }
  if (auto done = exchange(); !done) return done;
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Steady::now());
  if (left <= 0ms) return {};
  request_.wait_for_bytes(left, !going_.empty());
  return exchange();
}

Result<> MqttLink::connect() {
  const auto end = request_.turn();
  if (!end) return {};
  if (!end->problem.empty()) return fail(FaultKind::io, "{}", end->problem);
  connected_ = true;
  greet();
  return {};
}

void MqttLink::greet() {
  constexpr unsigned char kClean = 0x02, kWill = 0x04 | 0x08 | 0x20, kPassword = 0x40, kUser = 0x80;
  unsigned char flags = kClean;
  std::string body = counted(identity_);
  if (!will_.topic.empty()) {
    flags |= kWill;  // at least once, retained
    body += counted(will_.topic) + counted(will_.payload);
  }
  if (!options_.user.empty()) {
    flags |= kUser;
    body += counted(options_.user);
    if (!options_.password.empty()) flags |= kPassword;
    if (!options_.password.empty()) body += counted(options_.password);
  }
  put(kConnect, counted("MQTT") + '\x04' + static_cast<char>(flags) + number16(kKeepalive_s) + body);
}

void MqttLink::put(unsigned char head, const std::string& body) {
  going_ += static_cast<char>(head);
  for (auto left = body.size();; left /= 128) {
    going_ += static_cast<char>(left % 128 | (left >= 128 ? 128U : 0U));
    if (left < 128) break;
  }
  going_ += body;
  said_at_ = Steady::now();
}

Result<> MqttLink::exchange() {
  while (!going_.empty()) {
    const auto sent = request_.send(going_);
    if (!sent) return fail(sent.error());
    if (*sent == 0) break;
    going_.erase(0, *sent);
  }
  for (std::size_t all = 0;;) {
    std::array<char, 512> bytes;
    const auto came = request_.receive(bytes);
    if (!came) return fail(came.error());
    if (*came == 0) return {};
    if ((all += *came) > kMostAtOnce) return no_mqtt(fmt::format("more than {} bytes at once", kMostAtOnce));
    coming_.append(bytes.data(), *came);
    for (;;) {
      const auto taken = take_packet();
      if (!taken) return fail(taken.error());
      if (!*taken) break;
    }
  }
}

// false: it has not come whole yet.
Result<bool> MqttLink::take_packet() {
  if (coming_.size() < 2) return false;
  const auto length = static_cast<std::size_t>(static_cast<unsigned char>(coming_[1]));
  if (length > kMostMqttBytes)
    return no_mqtt(fmt::format("a packet of more than {} bytes, where it has only to confirm", kMostMqttBytes));
  if (coming_.size() < 2 + length) return false;
  const auto packet = coming_.substr(0, 2 + length);
  coming_.erase(0, packet.size());
  if (auto heard = hear(static_cast<unsigned char>(packet[0]), std::string_view(packet).substr(2)); !heard)
    return fail(heard.error());
  return true;
}

Result<> MqttLink::hear(unsigned char head, std::string_view body) {
  if (!answer_ && (head != kConnack || body.size() != 2)) return no_mqtt("its first word is no answer to ours");
  switch (head) {
    case kConnack:
      if (answer_ || body.size() != 2) return no_mqtt("a second welcome");
      answer_ = static_cast<unsigned char>(body[1]);
      return {};
    case kPuback:
      if (body.size() == 2 && unconfirmed_.erase(number_at(body, 0)) == 1) return {};
      return no_mqtt("it confirms what it was not told");
    case kPingresp:
      if (body.empty() && std::exchange(pinged_, false)) return {};
      return no_mqtt("an answer that nobody asked for");
    case kSuback:
      if (std::exchange(subscribing_, false)) return {};
      return no_mqtt("an answer that nobody asked for");
    case kPublish:
    case kPublish | kRetained: {
      const auto length = body.size() < 2 ? body.size() : number_at(body, 0);
      if (birth_topic_.empty() || body.size() < 2 + length || body.substr(2, length) != birth_topic_) break;
      born_ = born_ || (body.substr(2 + length) == "online" && head == kPublish);  // not one of long ago
      return {};
    }
    default: break;
  }
  return no_mqtt("it tells what nobody asked for");
}

void MqttLink::publish(const MqttMessage& message, bool retained) {
  number_ = number_ % 65535 + 1;
  unconfirmed_.insert(number_);
  put(kPublish | kAtLeastOnce | (retained ? kRetained : 0),
      counted(message.topic) + number16(number_) + message.payload);
}

void MqttLink::listen_for_birth(const std::string& prefix) {
  birth_topic_ = prefix + "/status";
  if (birth_topic_.size() + 2 + std::string_view("offline").size() > kMostMqttBytes) return birth_topic_.clear();
  subscribing_ = true;
  number_ = number_ % 65535 + 1;
  put(kSubscribe, number16(number_) + counted(birth_topic_) + '\0');
}

void MqttLink::say_goodbye() {
  put(kDisconnect, {});
}

}  // namespace kasumi::report
