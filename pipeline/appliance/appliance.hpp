// The appliance: its loops and their mailboxes. It starts no threads: a kiosk runs each loop in a thread of its own, a
// test calls them all from one thread under a manual clock.
#pragma once

#include "pipeline/appliance/check_loop.hpp"
#include "pipeline/appliance/render_loop.hpp"
#include "pipeline/appliance/scene_loop.hpp"
#include "pipeline/appliance/sky_loop.hpp"
#include "pipeline/appliance/status_loop.hpp"
#include "pipeline/appliance/visibility_loop.hpp"

namespace kasumi {

// What the appliance needs from the machine; tests supply their own.
struct ApplianceServices {
  Devices& devices;
  Clock& clock;
  TimeWatch& time;
  Notifier& notifier;
};

class Appliance {
 public:
  Appliance(std::filesystem::path config_file, ContentPtr content, const ApplianceServices& services,
            StatusOptions status, SkyWatchOptions sky = {});

  SceneLoop& scene() { return scene_; }
  SkyLoop& sky() { return sky_; }
  RenderLoop& render() { return render_; }
  StatusLoop& status() { return status_; }
  CheckLoop& check() { return check_; }
  VisibilityLoop& visibility() { return visibility_; }
  Bell& render_bell() { return mailboxes_.render.bell; }

  // Reads configuration and content again and hands them to the loops. When they are invalid, the old ones stay and
  // every problem is logged and reported in the status. BLOCKS for the seconds that reading takes. Any thread, but only
  // one at a time.
  void reload();

 private:
  std::filesystem::path config_file_;
  ApplianceServices services_;
  Mailboxes mailboxes_;
  SceneLoop scene_;
  SkyLoop sky_;
  RenderLoop render_;
  StatusLoop status_;
  CheckLoop check_;
  VisibilityLoop visibility_;
};

}  // namespace kasumi
