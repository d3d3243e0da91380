#include "pipeline/kiosk/appliance/mailboxes.hpp"

#include "pipeline/kiosk/appliance/status_mailbox.hpp"

namespace kasumi {

Mailboxes::Mailboxes() : status(std::make_unique<StatusMailbox>()) {}
Mailboxes::~Mailboxes() = default;

std::array<Mailbox*, 9> Mailboxes::all() {
  return {&scene, &sky, &render, &horizon, &check, &visibility, &proving, &television, status.get()};
}

std::array<const Mailbox*, 9> Mailboxes::all() const {
  return {&scene, &sky, &render, &horizon, &check, &visibility, &proving, &television, status.get()};
}

}  // namespace kasumi
