#include "report/web/web_request.hpp"

#include <algorithm>
#include <cstring>

#include <fmt/format.h>
#include <poll.h>

namespace kasumi::report {

using namespace std::chrono_literals;

bool is_web_address(std::string_view url) {
  if (url.size() > 1000 || !(url.starts_with("https://") || url.starts_with("http://"))) return false;
  const auto host = url.find("://") + 3;
  if (host == url.size() || std::string_view("/?#:@").find(url[host]) != std::string_view::npos) return false;
  return std::ranges::all_of(url, [](char c) { return c > 0x20 && c < 0x7f && c != '"' && c != '\\'; });
}

std::string host_of(const std::string& url) {
  const auto begin = url.find("://") + 3;
  auto host = url.substr(begin, url.find_first_of("/?#", begin) - begin);
  return host.substr(host.rfind('@') + 1);
}

WebRequest::WebRequest(const std::string& url, const std::string& ca_file, const char* protocols, Duration to_connect) {
  static const auto ready = curl_global_init(CURL_GLOBAL_DEFAULT);
  (void)ready;
  multi_.reset(curl_multi_init());
  easy_.reset(curl_easy_init());
  set(CURLOPT_URL, url.c_str());
  set(CURLOPT_PROTOCOLS_STR, protocols);
  set(CURLOPT_FOLLOWLOCATION, 0L);
  set(CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(to_connect / 1ms));
  set(CURLOPT_NOSIGNAL, 1L);
  set(CURLOPT_QUICK_EXIT, 1L);  // a name's look-up that hangs is left behind
  set(CURLOPT_USERAGENT, "kasumi-report");
  set(CURLOPT_ERRORBUFFER, static_cast<char*>(words_));
  set(CURLOPT_SSL_VERIFYPEER, 1L);
  set(CURLOPT_SSL_VERIFYHOST, 2L);
  if (ca_file.empty()) return;
  set(CURLOPT_CAINFO, ca_file.c_str());
  set(CURLOPT_CAPATH, static_cast<const char*>(nullptr));
}

WebRequest::~WebRequest() {
  if (begun_) curl_multi_remove_handle(multi_.get(), easy_.get());
}

std::optional<WebRequest::End> WebRequest::turn() {
  if (!multi_ || !easy_) return End{0, "no memory"};
  if (!begun_) begun_ = curl_multi_add_handle(multi_.get(), easy_.get()) == CURLM_OK;
  int running = 0, left = 0;
  curl_multi_perform(multi_.get(), &running);
  if (running > 0) return std::nullopt;
  const auto* message = curl_multi_info_read(multi_.get(), &left);
  const auto result = message ? message->data.result : CURLE_FAILED_INIT;
  // The library's own words name milliseconds, which would make each failure a new one.
  const bool by_tls = result == CURLE_PEER_FAILED_VERIFICATION || result == CURLE_SSL_CONNECT_ERROR ||
                      result == CURLE_SSL_CACERT_BADFILE;
  long error = 0;
  if (result == CURLE_COULDNT_CONNECT) curl_easy_getinfo(easy_.get(), CURLINFO_OS_ERRNO, &error);
  if (error != 0)
    return End{0, fmt::format("{} ({})", curl_easy_strerror(result), std::strerror(static_cast<int>(error)))};
  if (result != CURLE_OK) return End{0, by_tls && words_[0] ? std::string(words_) : curl_easy_strerror(result)};
  End end;
  curl_easy_getinfo(easy_.get(), CURLINFO_RESPONSE_CODE, &end.code);
  return end;
}

Result<std::size_t> WebRequest::send(std::string_view bytes) {
  std::size_t sent = 0;
  const auto result = curl_easy_send(easy_.get(), bytes.data(), bytes.size(), &sent);
  if (result == CURLE_OK || result == CURLE_AGAIN) return sent;
  return fail(FaultKind::disconnected, "the connection was lost ({})", curl_easy_strerror(result));
}

Result<std::size_t> WebRequest::receive(std::span<char> bytes) {
  std::size_t came = 0;
  const auto result = curl_easy_recv(easy_.get(), bytes.data(), bytes.size(), &came);
  if (result == CURLE_AGAIN) return std::size_t{0};
  if (result == CURLE_OK && came > 0) return came;
  if (result == CURLE_OK) return fail(FaultKind::disconnected, "the connection was closed");
  return fail(FaultKind::disconnected, "the connection was lost ({})", words_[0] ? words_ : curl_easy_strerror(result));
}

void WebRequest::wait_for_bytes(std::chrono::milliseconds longest, bool or_sent) {
  curl_socket_t socket = CURL_SOCKET_BAD;
  curl_easy_getinfo(easy_.get(), CURLINFO_ACTIVESOCKET, &socket);
  pollfd wanted{socket, static_cast<short>(POLLIN | (or_sent ? POLLOUT : 0)), 0};
  ::poll(&wanted, 1, static_cast<int>(longest.count()));
}

}  // namespace kasumi::report
