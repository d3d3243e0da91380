// One mail about the kiosk, as sendmail takes it.
#pragma once

#include <string>
#include <vector>

#include "base/words/language.hpp"
#include "report/channels/mail_watch.hpp"

namespace kasumi::report {

struct MailOptions {
  std::vector<std::string> to;
  std::string from;  // empty: as the machine's sendmail has it
  std::vector<std::string> command = {"/usr/sbin/sendmail", "-i", "-t"};
  Duration pause = std::chrono::minutes(15);  // between two mails, at least
  std::string memory_file = "/var/lib/kasumi-report/mail.txt";
};

// Something that can stand in a header as an address: one line, one word, one @.
bool is_mail_address(std::string_view text);

// Header and body, in UTF-8, no line longer than 900 bytes. `next` is when the next one comes at the earliest.
std::string mail_text(const MailNews& news, const MailOptions& options, const std::string& name, Language language,
                      Duration next);

// One that was asked for, to see whether mails arrive; it says what visitors see now.
std::string trial_mail(const MailOptions& options, const std::string& name, Language language, Sight sight);

}  // namespace kasumi::report
