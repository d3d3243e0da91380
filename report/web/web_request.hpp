// A GET from a web server that may be slow, endless, or an impostor.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <curl/curl.h>

#include "base/c_ptr.hpp"
#include "base/clock.hpp"
#include "base/result.hpp"

namespace kasumi::report {

// http:// or https:// with a host, one word.
bool is_web_address(std::string_view url);
// Of such an address, without what makes it a secret.
std::string host_of(const std::string& url);

// One exchange. Certificates are checked, nothing that is answered is followed, a proxy is the environment's.
class WebRequest {
 public:
  // `ca_file`: the authorities that may sign the server's certificate; empty: those the machine trusts. `protocols`:
  // "https", "http,https".
  WebRequest(const std::string& url, const std::string& ca_file, const char* protocols, Duration to_connect);
  ~WebRequest();
  WebRequest(const WebRequest&) = delete;
  WebRequest& operator=(const WebRequest&) = delete;

  template <class Value>
  void set(CURLoption option, Value value) {
    if (easy_) curl_easy_setopt(easy_.get(), option, value);
  }
  // Never waits. Once it is over: its code, such as 200, or why there is none.
  struct End {
    long code = 0;
    std::string problem;
  };
  std::optional<End> turn();

  // Once it is over, where only a connection was asked for (CURLOPT_CONNECT_ONLY). How many bytes went, or came; 0: none
  // now. Error (disconnected): the connection has ended, and why.
  Result<std::size_t> send(std::string_view bytes);
  Result<std::size_t> receive(std::span<char> bytes);
  // BLOCKS until bytes can be received, or sent where that is wanted, for at most `longest`.
  void wait_for_bytes(std::chrono::milliseconds longest, bool or_sent);

 private:
  char words_[CURL_ERROR_SIZE] = {};
  CPtr<CURLM, curl_multi_cleanup> multi_;
  CPtr<CURL, curl_easy_cleanup> easy_;
  bool begun_ = false;
};

}  // namespace kasumi::report
