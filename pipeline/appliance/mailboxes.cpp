#include "pipeline/appliance/mailboxes.hpp"

#include "pipeline/appliance/status_mailbox.hpp"

namespace kasumi {

Mailboxes::Mailboxes() : status(std::make_unique<StatusMailbox>()) {}
Mailboxes::~Mailboxes() = default;

std::array<Mailbox*, 6> Mailboxes::all() {
  return {&scene, &sky, &render, &check, &visibility, status.get()};
}

}  // namespace kasumi
