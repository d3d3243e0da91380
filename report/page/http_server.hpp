// A small HTTP server for peers that cannot be trusted: one thread, no waiting, bounded connections, memory and time.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace kasumi::report {

// A GET or HEAD, or a POST, whose body is not read. What a peer did not send is empty.
struct Request {
  bool posts = false;
  std::string path;      // "/metrics", as it was sent, without the query
  std::string language;  // of ?language=
  std::string view;      // of ?view=
  std::string key;       // of ?key=
  std::string accept_language, authorization, host;
  std::string address;  // of the peer, as a number; of IPv6 its network, since a peer has as many as it likes
};

struct Answer {
  int code = 200;
  std::string type = "text/plain; charset=utf-8";
  std::shared_ptr<const std::string> body;
  std::vector<std::pair<std::string, std::string>> headers;  // others
};
Answer plain_answer(int code, std::string text);
Answer only_reading();  // 405

struct HttpBounds {
  std::size_t connections = 48;                  // beyond them the oldest is cut off
  Duration exchange = std::chrono::seconds(20);  // the longest from connection, or last answer, to answer
  unsigned silence_s = 10;                       // without a byte
  std::size_t memory_bytes = 8 * 1024;           // of each connection: line, headers and all
};

class HttpServer {
 public:
  using Handler = std::function<Answer(const Request&)>;
  // Port 0: any. Errors: bad_input (no such address here, the port is taken or not allowed).
  static Result<HttpServer> listen(const std::string& address, int port, Clock& clock, Handler handler,
                                   HttpBounds bounds = {});
  HttpServer(HttpServer&&) noexcept;
  HttpServer& operator=(HttpServer&&) noexcept;
  ~HttpServer();

  int port() const;
  // Serves whoever has sent something. BLOCKS for at most `longest` where nobody has, and for what the handler takes.
  void turn(Duration longest);

  const std::map<std::string, std::uint64_t>& answered() const;  // by status code
  // By reason: "crowded", "slow", "unanswered" (what they sent was no request, or they went), and the codes of refusals.
  const std::map<std::string, std::uint64_t>& refused() const;
  std::size_t connections() const;

 private:
  struct Daemon;
  explicit HttpServer(std::unique_ptr<Daemon> daemon);
  std::unique_ptr<Daemon> daemon_;
};

}  // namespace kasumi::report
