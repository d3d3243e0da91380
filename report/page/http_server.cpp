#include "report/page/http_server.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string_view>

#include <arpa/inet.h>
#include <microhttpd.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

namespace kasumi::report {

namespace {

std::string address_of(MHD_Connection* connection) {
  const auto* info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
  if (!info || !info->client_addr) return {};
  char text[INET6_ADDRSTRLEN] = {};
  if (info->client_addr->sa_family == AF_INET) {
    const auto* four = reinterpret_cast<const sockaddr_in*>(info->client_addr);
    ::inet_ntop(AF_INET, &four->sin_addr, text, sizeof text);
  } else if (info->client_addr->sa_family == AF_INET6) {
    auto network = reinterpret_cast<const sockaddr_in6*>(info->client_addr)->sin6_addr;
    std::fill(network.s6_addr + 8, network.s6_addr + 16, std::uint8_t{0});
    ::inet_ntop(AF_INET6, &network, text, sizeof text);
  }
  return text;
}

constexpr std::size_t kBeyond = 16;  // connections that may wait to be cut off

// Everything that is answered is for whoever looks after the kiosk: nobody keeps it, frames it or guesses what it is.
constexpr std::pair<const char*, const char*> kHeaders[] = {
    {"Content-Security-Policy",
     "default-src 'none'; style-src 'self'; img-src data:; base-uri 'none'; form-action 'self'; frame-ancestors "
     "'none'"},
    {"X-Content-Type-Options", "nosniff"},
    {"Referrer-Policy", "no-referrer"},
    {"Cache-Control", "no-store"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
};

std::string text_of(MHD_Connection* connection, MHD_ValueKind kind, const char* key) {
  const char* value = MHD_lookup_connection_value(connection, kind, key);
  return value ? value : "";
}

void free_body(void* body) {
  delete static_cast<std::shared_ptr<const std::string>*>(body);
}

}  // namespace

Answer plain_answer(int code, std::string text) {
  return {code, "text/plain; charset=utf-8", std::make_shared<const std::string>(std::move(text)), {}};
}

Answer only_reading() {
  auto answer = plain_answer(405, "Only GET and HEAD.\n");
  answer.headers = {{"Allow", "GET, HEAD"}};
  return answer;
}

struct HttpServer::Daemon {
  struct Guest {
    Instant since;  // connected, or answered last
    int fd = -1;
    std::uint64_t number = 0;  // the order in which they came
    bool answered = false;
    bool cut = false;  // and counted
  };

  Daemon(Clock& own_clock, Handler own_handler, HttpBounds own_bounds)
      : clock(own_clock), handler(std::move(own_handler)), bounds(own_bounds) {}
  ~Daemon() {
    if (mhd) MHD_stop_daemon(mhd);
  }
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  Clock& clock;
  Handler handler;
  HttpBounds bounds;
  MHD_Daemon* mhd = nullptr;
  int epoll = -1;
  std::map<MHD_Connection*, Guest> guests;
  std::uint64_t came = 0;
  std::map<std::string, std::uint64_t> answered, refused;

  // The library notices that the connection is over, and closes it.
  void cut(Guest& guest, const char* why) {
    if (guest.cut) return;
    guest.cut = true;
    ++refused[why];
    ::shutdown(guest.fd, SHUT_RDWR);
  }

  void make_room() {
    const auto open = std::ranges::count_if(guests, [](const auto& guest) { return !guest.second.cut; });
    if (static_cast<std::size_t>(open) < bounds.connections) return;
    Guest* oldest = nullptr;
    for (auto& [connection, guest] : guests)
      if (!guest.cut && (!oldest || guest.number < oldest->number)) oldest = &guest;
    if (oldest) cut(*oldest, "crowded");
  }

  void cut_the_slow() {
    const auto now = clock.now();
    for (auto& [connection, guest] : guests)
      if (now - guest.since > bounds.exchange) cut(guest, "slow");
  }

  void begin(MHD_Connection* connection) {
    make_room();
    const auto* info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    guests[connection] = {clock.now(), info ? info->connect_fd : -1, ++came, false, false};
  }

  void end(MHD_Connection* connection) {
    const auto guest = guests.find(connection);
    if (guest == guests.end()) return;
    if (!guest->second.answered && !guest->second.cut) ++refused["unanswered"];
    guests.erase(guest);
  }

  MHD_Result answer(MHD_Connection* connection, const char* path, std::string_view method) {
    Answer answer;
    const bool reads = method == MHD_HTTP_METHOD_GET || method == MHD_HTTP_METHOD_HEAD;
    const bool posts = method == MHD_HTTP_METHOD_POST;
    if (!reads && !posts) {
      answer = only_reading();
    } else {
      Request request;
      request.posts = posts;
      request.path = path;
      request.language = text_of(connection, MHD_GET_ARGUMENT_KIND, "language");
      request.view = text_of(connection, MHD_GET_ARGUMENT_KIND, "view");
      request.key = text_of(connection, MHD_GET_ARGUMENT_KIND, "key");
      request.accept_language = text_of(connection, MHD_HEADER_KIND, MHD_HTTP_HEADER_ACCEPT_LANGUAGE);
      request.authorization = text_of(connection, MHD_HEADER_KIND, MHD_HTTP_HEADER_AUTHORIZATION);
      request.address = address_of(connection);
      request.host = text_of(connection, MHD_HEADER_KIND, MHD_HTTP_HEADER_HOST);
      answer = handler(request);
    }
    return send(connection, answer);
  }

  MHD_Result send(MHD_Connection* connection, const Answer& answer) {
    auto* body = new std::shared_ptr<const std::string>(answer.body ? answer.body : std::make_shared<std::string>());
    auto* response = MHD_create_response_from_buffer_with_free_callback_cls(
        (*body)->size(), const_cast<char*>((*body)->data()), free_body, body);
    if (!response) {
      delete body;
      return MHD_NO;
    }
    MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE, answer.type.c_str());
    for (const auto& [key, value] : kHeaders) MHD_add_response_header(response, key, value);
    for (const auto& [key, value] : answer.headers) MHD_add_response_header(response, key.c_str(), value.c_str());
    const auto queued = MHD_queue_response(connection, static_cast<unsigned>(answer.code), response);
    MHD_destroy_response(response);
    if (queued == MHD_YES) {
      const auto code = std::to_string(answer.code);
      ++answered[code];
      if (answer.code >= 400) ++refused[code];
      guests[connection].answered = true;
    }
    return queued;
  }
};

namespace {

sockaddr_storage address_of(const std::string& text, int port, bool& known) {
  sockaddr_storage storage{};
  auto* four = reinterpret_cast<sockaddr_in*>(&storage);
  auto* six = reinterpret_cast<sockaddr_in6*>(&storage);
  known = true;
  if (::inet_pton(AF_INET, text.c_str(), &four->sin_addr) == 1) {
    four->sin_family = AF_INET;
    four->sin_port = htons(static_cast<std::uint16_t>(port));
  } else if (::inet_pton(AF_INET6, text.c_str(), &six->sin6_addr) == 1) {
    six->sin6_family = AF_INET6;
    six->sin6_port = htons(static_cast<std::uint16_t>(port));
  } else {
    known = false;
  }
  return storage;
}

void say_nothing(void*, const char*, va_list) {}  // peers must not fill our log

// None of our addresses needs it, and what is not decoded leads nowhere.
std::size_t leave_encoded(void*, MHD_Connection*, char* text) {
  return std::strlen(text);
}

}  // namespace

Result<HttpServer> HttpServer::listen(const std::string& address, int port, Clock& clock, Handler handler,
                                      HttpBounds bounds) {
  bool known = false;
  const auto storage = address_of(address, port, known);
  if (!known) return fail(FaultKind::bad_input, "{}: expected an address like 127.0.0.1 or ::1", address);
  auto daemon = std::make_unique<Daemon>(clock, std::move(handler), bounds);
  using Told = Daemon;
  const MHD_AccessHandlerCallback on_request = [](void* told, MHD_Connection* connection, const char* path,
                                                  const char* method, const char*, const char*, std::size_t*, void**) {
    return static_cast<Told*>(told)->answer(connection, path, method);
  };
  const MHD_RequestCompletedCallback on_completed = [](void* told, MHD_Connection* connection, void**,
                                                       MHD_RequestTerminationCode) {
    auto& daemon_of = *static_cast<Told*>(told);
    if (const auto guest = daemon_of.guests.find(connection); guest != daemon_of.guests.end())
      guest->second.since = daemon_of.clock.now();
  };
  const MHD_NotifyConnectionCallback on_connection = [](void* told, MHD_Connection* connection, void**,
                                                        MHD_ConnectionNotificationCode code) {
    code == MHD_CONNECTION_NOTIFY_STARTED ? static_cast<Told*>(told)->begin(connection)
                                          : static_cast<Told*>(told)->end(connection);
  };
  const unsigned six = storage.ss_family == AF_INET6 ? MHD_USE_IPv6 : 0;
  errno = 0;
  daemon->mhd =
      MHD_start_daemon(MHD_USE_EPOLL | MHD_USE_ERROR_LOG | six, static_cast<std::uint16_t>(port), nullptr, nullptr,
                       on_request, daemon.get(), MHD_OPTION_EXTERNAL_LOGGER, say_nothing, nullptr, MHD_OPTION_SOCK_ADDR,
                       &storage, MHD_OPTION_CONNECTION_LIMIT, static_cast<unsigned>(bounds.connections + kBeyond),
                       MHD_OPTION_CONNECTION_MEMORY_LIMIT, bounds.memory_bytes, MHD_OPTION_CONNECTION_TIMEOUT,
                       bounds.silence_s, MHD_OPTION_STRICT_FOR_CLIENT, 1, MHD_OPTION_UNESCAPE_CALLBACK, leave_encoded,
                       nullptr, MHD_OPTION_NOTIFY_COMPLETED, on_completed, daemon.get(), MHD_OPTION_NOTIFY_CONNECTION,
                       on_connection, daemon.get(), MHD_OPTION_END);
  if (!daemon->mhd)
    return fail(FaultKind::bad_input, "{} port {}: cannot be listened at: {}", address, port, std::strerror(errno));
  daemon->epoll = MHD_get_daemon_info(daemon->mhd, MHD_DAEMON_INFO_EPOLL_FD)->epoll_fd;
  return HttpServer(std::move(daemon));
}

HttpServer::HttpServer(std::unique_ptr<Daemon> daemon) : daemon_(std::move(daemon)) {}
HttpServer::HttpServer(HttpServer&&) noexcept = default;
HttpServer& HttpServer::operator=(HttpServer&&) noexcept = default;
HttpServer::~HttpServer() = default;

int HttpServer::port() const {
  return MHD_get_daemon_info(daemon_->mhd, MHD_DAEMON_INFO_BIND_PORT)->port;
}

void HttpServer::turn(Duration longest) {
  auto wait_ms = std::chrono::ceil<std::chrono::milliseconds>(longest).count();
  MHD_UNSIGNED_LONG_LONG sooner_ms = 0;
  if (MHD_get_timeout(daemon_->mhd, &sooner_ms) == MHD_YES)
    wait_ms = std::min<long long>(wait_ms, static_cast<long long>(sooner_ms));
  pollfd events{daemon_->epoll, POLLIN, 0};
  ::poll(&events, 1, static_cast<int>(wait_ms));
  daemon_->cut_the_slow();
  MHD_run(daemon_->mhd);
}

const std::map<std::string, std::uint64_t>& HttpServer::answered() const {
  return daemon_->answered;
}

const std::map<std::string, std::uint64_t>& HttpServer::refused() const {
  return daemon_->refused;
}

std::size_t HttpServer::connections() const {
  return daemon_->guests.size();
}

}  // namespace kasumi::report
