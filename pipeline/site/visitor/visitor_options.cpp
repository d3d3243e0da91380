#include "pipeline/site/visitor/visitor_options.hpp"

#include <algorithm>
#include <charconv>

#include <linux/input-event-codes.h>

namespace kasumi {

namespace {

constexpr std::size_t kMostInputDevices = 16;

struct NamedInputKey {
  std::string_view name;
  int code;
};
#define KASUMI_KEY(name) \
  { #name, name }
constexpr NamedInputKey kInputKeys[] = {
    KASUMI_KEY(KEY_ESC),        KASUMI_KEY(KEY_1),      KASUMI_KEY(KEY_2),         KASUMI_KEY(KEY_3),
    KASUMI_KEY(KEY_4),          KASUMI_KEY(KEY_5),      KASUMI_KEY(KEY_6),         KASUMI_KEY(KEY_7),
    KASUMI_KEY(KEY_8),          KASUMI_KEY(KEY_9),      KASUMI_KEY(KEY_0),         KASUMI_KEY(KEY_BACKSPACE),
    KASUMI_KEY(KEY_TAB),        KASUMI_KEY(KEY_ENTER),  KASUMI_KEY(KEY_SPACE),     KASUMI_KEY(KEY_A),
    KASUMI_KEY(KEY_B),          KASUMI_KEY(KEY_C),      KASUMI_KEY(KEY_D),         KASUMI_KEY(KEY_E),
    KASUMI_KEY(KEY_F),          KASUMI_KEY(KEY_G),      KASUMI_KEY(KEY_H),         KASUMI_KEY(KEY_I),
    KASUMI_KEY(KEY_J),          KASUMI_KEY(KEY_K),      KASUMI_KEY(KEY_L),         KASUMI_KEY(KEY_M),
    KASUMI_KEY(KEY_N),          KASUMI_KEY(KEY_O),      KASUMI_KEY(KEY_P),         KASUMI_KEY(KEY_Q),
    KASUMI_KEY(KEY_R),          KASUMI_KEY(KEY_S),      KASUMI_KEY(KEY_T),         KASUMI_KEY(KEY_U),
    KASUMI_KEY(KEY_V),          KASUMI_KEY(KEY_W),      KASUMI_KEY(KEY_X),         KASUMI_KEY(KEY_Y),
    KASUMI_KEY(KEY_Z),          KASUMI_KEY(KEY_F1),     KASUMI_KEY(KEY_F2),        KASUMI_KEY(KEY_F3),
    KASUMI_KEY(KEY_F4),         KASUMI_KEY(KEY_F5),     KASUMI_KEY(KEY_F6),        KASUMI_KEY(KEY_F7),
    KASUMI_KEY(KEY_F8),         KASUMI_KEY(KEY_F9),     KASUMI_KEY(KEY_F10),       KASUMI_KEY(KEY_F11),
    KASUMI_KEY(KEY_F12),        KASUMI_KEY(KEY_UP),     KASUMI_KEY(KEY_DOWN),      KASUMI_KEY(KEY_LEFT),
    KASUMI_KEY(KEY_RIGHT),      KASUMI_KEY(KEY_KP0),    KASUMI_KEY(KEY_KP1),       KASUMI_KEY(KEY_KP2),
    KASUMI_KEY(KEY_KP3),        KASUMI_KEY(KEY_KP4),    KASUMI_KEY(KEY_KP5),       KASUMI_KEY(KEY_KP6),
    KASUMI_KEY(KEY_KP7),        KASUMI_KEY(KEY_KP8),    KASUMI_KEY(KEY_KP9),       KASUMI_KEY(KEY_KPDOT),
    KASUMI_KEY(KEY_KPENTER),    KASUMI_KEY(KEY_KPPLUS), KASUMI_KEY(KEY_KPMINUS),   KASUMI_KEY(KEY_KPASTERISK),
    KASUMI_KEY(KEY_KPSLASH),    KASUMI_KEY(KEY_MUTE),   KASUMI_KEY(KEY_PLAYPAUSE), KASUMI_KEY(KEY_VOLUMEUP),
    KASUMI_KEY(KEY_VOLUMEDOWN), KASUMI_KEY(BTN_0),      KASUMI_KEY(BTN_1),         KASUMI_KEY(BTN_2),
    KASUMI_KEY(BTN_3),          KASUMI_KEY(BTN_4),      KASUMI_KEY(BTN_5),         KASUMI_KEY(BTN_6),
    KASUMI_KEY(BTN_7),          KASUMI_KEY(BTN_8),      KASUMI_KEY(BTN_9),         KASUMI_KEY(BTN_LEFT),
    KASUMI_KEY(BTN_RIGHT),      KASUMI_KEY(BTN_MIDDLE), KASUMI_KEY(BTN_TRIGGER),   KASUMI_KEY(BTN_THUMB),
    KASUMI_KEY(BTN_THUMB2),     KASUMI_KEY(BTN_TOP),    KASUMI_KEY(BTN_TOP2),      KASUMI_KEY(BTN_PINKIE),
    KASUMI_KEY(BTN_BASE),       KASUMI_KEY(BTN_BASE2),  KASUMI_KEY(BTN_BASE3),     KASUMI_KEY(BTN_BASE4),
    KASUMI_KEY(BTN_BASE5),      KASUMI_KEY(BTN_BASE6),  KASUMI_KEY(BTN_SOUTH),     KASUMI_KEY(BTN_EAST),
    KASUMI_KEY(BTN_NORTH),      KASUMI_KEY(BTN_WEST),   KASUMI_KEY(BTN_TL),        KASUMI_KEY(BTN_TR),
    KASUMI_KEY(BTN_SELECT),     KASUMI_KEY(BTN_START)};
#undef KASUMI_KEY

std::vector<std::filesystem::path> read_devices(const ConfigTable& table) {
  std::vector<std::filesystem::path> devices;
  for (const auto& name : table.texts("devices")) {
    const std::filesystem::path device = name;
    if (!name.starts_with("/dev/input/") || device != device.lexically_normal())
      table.problem("devices", fmt::format("paths like \"/dev/input/by-id/usb-...-event-kbd\", not \"{}\"", name));
    if (std::ranges::find(devices, device) != devices.end())
      table.problem("devices", fmt::format("each device once, not \"{}\" again", name));
    devices.push_back(device);
  }
  if (devices.empty() || devices.size() > kMostInputDevices)
    table.problem("devices", fmt::format("1 to {} devices", kMostInputDevices));
  return devices;
}

// One key does one thing.
std::vector<int> read_keys(const ConfigTable& table, std::string_view key, std::vector<int>& taken) {
  std::vector<int> codes;
  if (!table.has(key)) return codes;
  for (const auto& name : table.texts(key)) {
    const auto code = input_key(name);
    if (!code) {
      table.problem(key, fmt::format("keys like \"KEY_SPACE\" or \"BTN_TRIGGER\", or numbers of 1 to {} as evtest "
                                     "shows them, in quotes; not \"{}\"",
                                     KEY_MAX, name));
    } else if (std::ranges::find(taken, *code) != taken.end()) {
      table.problem(key, fmt::format("a key that is used once, not \"{}\" again", name));
    } else {
      taken.push_back(*code);
      codes.push_back(*code);
    }
  }
  return codes;
}

std::vector<Language> read_languages(const ConfigTable& table) {
  std::vector<Language> languages;
  if (!table.has("languages")) return languages;
  for (const auto& code : table.texts("languages")) {
    const auto language = parse_language(code);
    if (!language)
      table.problem("languages", language.error().message);
    else if (std::ranges::find(languages, *language) != languages.end())
      table.problem("languages", fmt::format("each language once, not \"{}\" again", code));
    else
      languages.push_back(*language);
  }
  return languages;
}

std::vector<HandKey> read_hints(const ConfigTable& table, const VisitorOptions& options) {
  std::vector<HandKey> hints;
  if (!table.has("hints")) return hints;
  for (const auto& name : table.texts("hints")) {
    const auto key = static_cast<std::size_t>(std::ranges::find(kHandKeyNames, name) - kHandKeyNames.begin());
    if (key == kHandKeys)
      table.problem("hints", fmt::format("one of {}, not \"{}\"", fmt::join(kHandKeyNames, ", "), name));
    else if (options.keys[key].empty())
      table.problem("hints", fmt::format("actions that have a key: \"{}\" has none", name));
    else if (std::ranges::find(hints, static_cast<HandKey>(key)) != hints.end())
      table.problem("hints", fmt::format("each action once, not \"{}\" again", name));
    else
      hints.push_back(static_cast<HandKey>(key));
  }
  return hints;
}

}  // namespace

std::optional<int> input_key(std::string_view name) {
  for (const auto& key : kInputKeys)
    if (key.name == name) return key.code;
  int code = 0;
  const auto read = std::from_chars(name.data(), name.data() + name.size(), code);
  const bool whole = read.ec == std::errc{} && read.ptr == name.data() + name.size();
  return whole && code >= 1 && code <= KEY_MAX ? std::optional(code) : std::nullopt;
}

std::string input_key_name(int code) {
  const auto* key = std::ranges::find(kInputKeys, code, &NamedInputKey::code);
  return key != std::end(kInputKeys) ? std::string(key->name) : fmt::format("{}", code);
}

std::optional<VisitorOptions> read_visitor(const ConfigTable& root) {
  const auto table = root.optional_table("visitor");
  if (!table) return std::nullopt;
  VisitorOptions options;
  options.devices = read_devices(*table);
  std::vector<int> taken;
  for (std::size_t i = 0; i < kHandKeys; ++i) options.keys[i] = read_keys(*table, kHandKeyNames[i], taken);
  options.hints = read_hints(*table, options);
  options.notch = table->number("notch", {0.005, 0.5}, options.notch);
  options.languages = read_languages(*table);
  options.idle = from_seconds(table->number("idle_s", {5.0, 600.0}, to_seconds(options.idle)));
  options.left_handed = table->flag("left_handed", options.left_handed);
  options.seated = table->flag("seated", options.seated);
  options.pixels_per_degree = table->number("pixels_per_degree", {5.0, 500.0}, options.pixels_per_degree);
  return options;
}

}  // namespace kasumi
