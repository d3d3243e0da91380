// The appliance: its loops and what passes between them. Knows no threads: in a kiosk each loop has its own, in a test
// one thread calls them all by a clock it turns.
#pragma once

#include "pipeline/appliance/check_loop.hpp"
#include "pipeline/appliance/render_loop.hpp"
#include "pipeline/appliance/scene_loop.hpp"
#include "pipeline/appliance/sky_loop.hpp"
#include "pipeline/appliance/status_loop.hpp"
#include "pipeline/appliance/visibility_loop.hpp"

namespace kasumi {

// What the appliance stands on; tests bring their own.
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

  // Reads configuration and content anew and hands them to the loops; refused, the old ones stay and every problem is
  // logged and told. BLOCKS for the seconds reading takes, in whatever thread; not for two at once.
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
