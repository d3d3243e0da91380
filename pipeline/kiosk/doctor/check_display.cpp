#include <algorithm>

#include "pipeline/kiosk/doctor/checks.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr int kPictures = 60;
constexpr Duration kLongFlip = 500ms;

std::string text_of(const ListedConnector& connector) {
  return fmt::format("{} ({}{}{})", connector.name, connector.connection, connector.display.empty() ? "" : ", ",
                     connector.display);
}

bool offers(const ListedConnector& connector, const KmsDisplayOptions& options) {
  const auto size = fmt::format("{}x{}", options.width, options.height);
  return std::any_of(connector.modes.begin(), connector.modes.end(), [&](const std::string& mode) {
    return mode.starts_with(size + "@") || mode.starts_with(size + "i@");
  });
}

std::string list_of(const std::vector<std::string>& modes) {
  std::string text;
  for (std::size_t i = 0; i < modes.size() && i < 12; ++i) text += (i ? ", " : "") + modes[i];
  return text + (modes.size() > 12 ? ", ..." : "");
}

}  // namespace

void check_connectors(const std::vector<ListedCard>& cards, const KmsDisplayOptions& options, Findings& findings) {
  if (cards.empty()) {
    findings.fail("display.card", "this machine has no graphics card with display outputs",
                  "missing driver? dmesg | grep drm; ls /dev/dri; missing firmware package?");
    return;
  }
  std::string there;
  const ListedConnector* chosen = nullptr;
  for (const auto& card : cards) {
    const auto name = card.by_path.empty() ? card.path : card.by_path;
    if (!card.problem.empty())
      findings.warn("display.card", fmt::format("{}: {}", card.path, card.problem),
                    "permission? id must show the group video");
    else
      findings.good("display.card",
                    fmt::format("{}: {}{}", name, card.driver, card.atomic ? ", atomic" : ", legacy calls"));
    if (card.users.empty())
      findings.good("display.master", fmt::format("{}: no other user visible to this account", card.path));
    else
      findings.good("display.master", fmt::format("{}: {}", card.path, card.users));
    if (!card.plane_formats.empty())
      findings.good("display.planes", fmt::format("{}: the building can lie on a plane of its own over pictures in {}",
                                                  card.path, list_of(card.plane_formats)));
    else if (!card.no_planes.empty())
      findings.good("display.planes", fmt::format("{}: the GPU composes each picture: {}", card.path, card.no_planes));
    for (const auto& connector : card.connectors) {
      there += (there.empty() ? "" : ", ") + text_of(connector);
      const bool asked =
          options.connector.empty() ? connector.connection == "connected" : connector.name == options.connector;
      const bool on_card = options.device.empty() || options.device == card.path || options.device == card.by_path;
      if (asked && on_card && !chosen) chosen = &connector;
    }
  }
  if (!chosen) {
    findings.fail("display.connector",
                  options.connector.empty() ? "no screen is connected"
                                            : fmt::format("there is no connector {}", options.connector),
                  there.empty() ? "check the cable; is the screen on?"
                                : "check the cable; is the screen on? connectors: " + there);
    return;
  }
  if (chosen->connection == "disconnected") {
    findings.fail("display.connector", text_of(*chosen), "check the cable; is the screen on? connectors: " + there);
    return;
  }
  findings.good("display.connector",
                fmt::format("{}{}{}", text_of(*chosen), chosen->mode_now.empty() ? "" : ", now ", chosen->mode_now));
  if (chosen->modes.empty())
    findings.fail("display.modes", "the screen lists no modes",
                  "try another cable (broken data lines) or input of the screen; dmesg | grep -i edid");
  else if (options.width > 0 && !offers(*chosen, options))
    findings.fail("display.modes", fmt::format("no {}x{}", options.width, options.height),
                  "it offers " + list_of(chosen->modes));
  else
    findings.good("display.modes", list_of(chosen->modes));
}

void check_flips(Display& display, Clock& clock, Findings& findings) {
  const auto timing = measure_flips(display, clock, kPictures);
  if (!timing) {
    findings.fail("display.flips", timing.error().message, "cable and converter; dmesg | grep drm");
    return;
  }
  const auto ms = [](Duration duration) { return to_seconds(duration) * 1e3; };
  const auto found = fmt::format("every {:.1f} ms, at worst {:.1f} ms; {:.1f} ms from picture to screen",
                                 ms(timing->median_interval), ms(timing->longest_interval), ms(timing->median_latency));
  auto& finding =
      timing->longest_interval > kLongFlip
          ? findings.warn("display.flips", found, "a busy machine (top), or driver problems: dmesg | grep drm")
          : findings.good("display.flips", found);
  finding.values = {{"interval_ms", ms(timing->median_interval)},
                    {"longest_ms", ms(timing->longest_interval)},
                    {"latency_ms", ms(timing->median_latency)}};
}

void check_mixing(const GlInfo& info, Mixing mixing, Findings& findings) {
  const bool processor = mixing == Mixing::processor || (mixing == Mixing::automatic && info.software);
  findings.good("display.mixing",
                fmt::format("the {} is to mix each picture with the building's layer{}",
                            processor ? "processor" : "GPU", mixing == Mixing::automatic ? "" : ", as configured"));
}

void check_gl_context(const GlInfo& info, Findings& findings) {
  const auto found = fmt::format("{}, {}", info.renderer, info.version);
  if (info.software)
    findings.warn(
        "gl.renderer", found + ": software rendering on the CPU",
        "no GPU or no driver for it: sudo apt install libgl1-mesa-dri; ls -l /dev/dri; id must show the group render; "
        "expect only a few pictures a second");
  else
    findings.good("gl.renderer", found);
  const bool imports = info.has("GL_OES_EGL_image");
  const bool robust = info.has("GL_EXT_robustness") || info.has("GL_KHR_robustness");
  auto& finding = findings.good(
      "gl.extensions", fmt::format("camera buffers {}; a lost context {}", imports ? "can be imported" : "are copied",
                                   robust ? "is detected at once" : "is detected by GL errors"));
  finding.values = {{"egl_image", imports}, {"robustness", robust}, {"max_texture_size", info.max_texture_size}};
}

}  // namespace kasumi
