#include "pipeline/kiosk/content/arrival.hpp"

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/lasting_file.hpp"
#include "base/outside/json_depth.hpp"
#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"

namespace kasumi {

namespace {

constexpr const char* kArrivalFile = "arrived.json";
constexpr std::size_t kMostArrivalWords = 1000;  // bytes; the first problems say enough

// Whole characters of it.
std::string shortened(const std::string& text) {
  if (text.size() <= kMostArrivalWords) return text;
  auto end = kMostArrivalWords;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0u) == 0x80u) --end;
  return text.substr(0, end) + " ...";
}

}  // namespace

Result<> note_arrival(const std::filesystem::path& content, const Arrival& arrival) {
  if (auto made = create_folders(content); !made) return made;
  const nlohmann::ordered_json json{{"utc", utc_text(std::chrono::floor<std::chrono::seconds>(arrival.utc))},
                                    {"from", arrival.from},
                                    {"taken", arrival.taken},
                                    {"words", shortened(arrival.words)}};
  return write_text_file(content / kArrivalFile, text_of_json(json, 1) + "\n");
}

std::optional<Arrival> last_arrival(const std::filesystem::path& content) {
  std::error_code error;
  if (content.empty() || !std::filesystem::is_regular_file(content / kArrivalFile, error)) return std::nullopt;
  const auto json = parse_json(modest_json(read_text_file(content / kArrivalFile, kSmallFile).value_or("")));
  if (!json.is_object()) return std::nullopt;
  const auto text = [&](const char* key) {
    return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : std::string();
  };
  const auto utc = parse_utc(text("utc"));
  if (!utc) return std::nullopt;
  return Arrival{*utc, text("from"), text("words"), json.contains("taken") && json["taken"] == true};
}

}  // namespace kasumi
