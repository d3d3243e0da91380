// Mail when the kiosk's state changes, through the machine's sendmail.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "report/channels/mail_text.hpp"
#include "report/channels/sendmail.hpp"

namespace kasumi::report {

class MailChannel {
 public:
  MailChannel(MailOptions options, std::string name, Language language, Clock& clock);

  // Call it after each look at the kiosk. Never waits.
  void tell(const Heard& heard);

  std::uint64_t sent() const { return sent_; }
  std::uint64_t failed() const { return failed_; }

 private:
  void finish(const Result<>& done);

  MailOptions options_;
  std::string name_;
  Language language_;
  Clock& clock_;
  MailWatch watch_;
  std::optional<Sendmail> running_;
  MailNews news_;  // that it carries
  std::string problem_;
  std::uint64_t sent_ = 0, failed_ = 0;
};

}  // namespace kasumi::report
