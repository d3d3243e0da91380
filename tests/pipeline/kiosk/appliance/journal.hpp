// What is logged while it lives.
#pragma once

#include <memory>
#include <sstream>
#include <string>

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

namespace kasumi {

class Journal {
 public:
  Journal() : before_(spdlog::default_logger()) {
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>("journal", std::make_shared<spdlog::sinks::ostream_sink_mt>(text_)));
  }
  ~Journal() { spdlog::set_default_logger(before_); }
  std::string text() const { return text_.str(); }
  int count(const std::string& words) const {
    const auto all = text();
    int found = 0;
    for (std::size_t at = 0; (at = all.find(words, at)) != std::string::npos; ++at) ++found;
    return found;
  }

 private:
  std::ostringstream text_;
  std::shared_ptr<spdlog::logger> before_;
};

}  // namespace kasumi
