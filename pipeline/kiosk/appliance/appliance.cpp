#include "pipeline/kiosk/appliance/appliance.hpp"

#include "pipeline/machine/rest_period.hpp"

namespace kasumi {

namespace {

RestPeriod rest_of(const StartRecord& starts, const std::string& camera) {
  const double lasts_s = rest_s(starts, camera);
  if (lasts_s <= 0.0) return {};
  const int times = starts.hung_openings.at(camera);
  return {from_seconds(lasts_s),
          fmt::format("left alone for {:.0f} min: its opening hung {}", lasts_s / 60.0,
                      times > 1 ? fmt::format("{} times in a row", times) : "at the last start")};
}

}  // namespace

std::unique_ptr<Devices> resting(Devices& devices, const StartRecord& starts, Clock& clock) {
  return resting(devices, rest_of(starts, "scene"), rest_of(starts, "sky"), clock);
}

Appliance::Appliance(ContentPlace place, ContentPtr content, const ApplianceServices& services, StatusOutputs status,
                     ObservationPlan sky)
    : notifier_(services.notifier, mailboxes_.proving.alive),
      scene_(content, services.devices, services.clock, mailboxes_),
      sky_(content, services.devices, services.clock, services.time, mailboxes_, std::move(sky)),
      render_(content, services.devices, services.clock, notifier_, mailboxes_),
      horizon_(content, services.clock, mailboxes_),
      snapshot_(
          status.file ? std::optional(status.file->parent_path()) : std::nullopt,
          [this](SnapshotKind kind) {
            mailboxes_.render.snapshot.put(kind);
            mailboxes_.render.bell.ring();
          },
          mailboxes_.snapshot, services.clock),
      proving_(content, services.proving, {place, status.file, [this] { reload_.ask(); }}, services.clock, mailboxes_),
      status_(content, std::move(status), services.clock, services.notifier, mailboxes_),
      check_(content, services.clock, mailboxes_),
      visibility_(content, services.clock, mailboxes_),
      television_(content->config.cec, services.devices, services.clock),
      clock_(services.clock),
      reload_(std::move(place), std::move(content), services.clock, services.notifier, mailboxes_, services.probes) {}

Instant Appliance::step_television() {
  auto& mailbox = mailboxes_.television;
  mailbox.pulse.turn(clock_.now(), kComputingBound);
  if (const auto content = mailbox.content.take()) television_.use((*content)->config.cec);
  if (const auto on = mailbox.on.take()) television_.want(*on);
  mailboxes_.status->television.put(television_.status());
  const auto again = television_.step();
  mailboxes_.status->television.put(television_.status());
  return again;
}

}  // namespace kasumi
