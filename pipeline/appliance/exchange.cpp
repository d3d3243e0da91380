#include "pipeline/appliance/exchange.hpp"

#include "pipeline/appliance/status_mail.hpp"

namespace kasumi {

Exchange::Exchange() : status(std::make_unique<StatusMail>()) {}
Exchange::~Exchange() = default;

std::array<Mail*, 6> Exchange::mails() {
  return {&scene, &sky, &render, &check, &visibility, status.get()};
}

}  // namespace kasumi
