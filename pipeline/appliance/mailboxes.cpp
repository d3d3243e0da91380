#include "pipeline/appliance/mailboxes.hpp"

#include "pipeline/appliance/status_mailbox.hpp"

namespace kasumi {

Mailboxes::Mailboxes() : status(std::make_unique<StatusMailbox>()) {}
Mailboxes::~Mailboxes() = default;

std::array<Mailbox*, 8> Mailboxes::all() {
  return {&scene, &sky, &render, &horizon, &check, &visibility, &proving, status.get()};
}

std::array<const Mailbox*, 8> Mailboxes::all() const {
  return {&scene, &sky, &render, &horizon, &check, &visibility, &proving, status.get()};
}

}  // namespace kasumi
