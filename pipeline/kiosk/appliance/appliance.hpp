// The appliance: its loops and their mailboxes. It starts no threads: a kiosk runs each loop in a thread of its own, a
// test calls them all from one thread under a manual clock.
#pragma once

#include "pipeline/kiosk/appliance/check_loop.hpp"
#include "pipeline/kiosk/appliance/horizon_loop.hpp"
#include "pipeline/kiosk/appliance/proving_loop.hpp"
#include "pipeline/kiosk/appliance/reload_loop.hpp"
#include "pipeline/kiosk/appliance/render_loop.hpp"
#include "pipeline/kiosk/appliance/scene_loop.hpp"
#include "pipeline/kiosk/appliance/sky_loop.hpp"
#include "pipeline/kiosk/appliance/snapshot_server.hpp"
#include "pipeline/kiosk/appliance/status_loop.hpp"
#include "pipeline/kiosk/appliance/visibility_loop.hpp"
#include "pipeline/kiosk/loop/television_switch.hpp"

namespace kasumi {

// What the appliance needs from the machine; tests supply their own.
struct ApplianceServices {
  Devices& devices;
  Clock& clock;
  TimeWatch& time;
  Notifier& notifier;
  ProvingRecords proving{};
  ReloadLoop::Probes probes{};  // empty: the machine's own
};

// Whose cameras rest that hung at the starts before this one. `devices` and `clock` must outlive it.
std::unique_ptr<Devices> resting(Devices& devices, const StartRecord& starts, Clock& clock);

// Passes everything on, and counts how often the render loop was alive.
class CountingNotifier final : public Notifier {
 public:
  CountingNotifier(Notifier& to, std::atomic<std::uint64_t>& alive) : to_(to), alive_(alive) {}
  void ready() override { to_.ready(); }
  void status(const std::string& line) override { to_.status(line); }
  void alive() override {
    ++alive_;
    to_.alive();
  }
  void extend_start(Duration by) override { to_.extend_start(by); }
  void reloading() override { to_.reloading(); }
  void stopping() override { to_.stopping(); }

 private:
  Notifier& to_;
  std::atomic<std::uint64_t>& alive_;
};

class Appliance {
 public:
  Appliance(ContentPlace place, ContentPtr content, const ApplianceServices& services, StatusOutputs status,
            ObservationPlan sky = {});

  SceneLoop& scene() { return scene_; }
  SkyLoop& sky() { return sky_; }
  RenderLoop& render() { return render_; }
  HorizonLoop& horizon() { return horizon_; }
  StatusLoop& status() { return status_; }
  CheckLoop& check() { return check_; }
  VisibilityLoop& visibility() { return visibility_; }
  SnapshotServer& snapshot() { return snapshot_; }
  Bell& snapshot_bell() { return mailboxes_.snapshot.bell; }
  ProvingLoop& proving() { return proving_; }
  // The television's loop. BLOCKS for a few seconds when it is switched. Returns when to be called again unless the bell
  // rings.
  Instant step_television();
  ReloadLoop& reload() { return reload_; }
  Bell& horizon_bell() { return mailboxes_.horizon.bell; }
  Bell& television_bell() { return mailboxes_.television.bell; }
  Bell& render_bell() { return mailboxes_.render.bell; }
  Bell& reload_bell() { return mailboxes_.reload.bell; }

 private:
  Mailboxes mailboxes_;
  CountingNotifier notifier_;
  SceneLoop scene_;
  SkyLoop sky_;
  RenderLoop render_;
  HorizonLoop horizon_;
  SnapshotServer snapshot_;
  ProvingLoop proving_;
  StatusLoop status_;
  CheckLoop check_;
  VisibilityLoop visibility_;
  TelevisionSwitch television_;
  Clock& clock_;
  ReloadLoop reload_;
};

}  // namespace kasumi
