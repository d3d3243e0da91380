#include "history/history_line.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "base/utc_text.hpp"

namespace kasumi {

namespace {

constexpr std::size_t kChecksumDigits = 8;
constexpr std::size_t kTextBytes = kHistoryLineBytes - kChecksumDigits - 1;  // before it; behind it the line end
constexpr std::uint32_t kLargestNumber = 0xfffffff;                          // 7 hexadecimal digits: 500 years

// Reflected CRC-32 (ISO-HDLC), as of zlib.
std::uint32_t checksum_of(std::string_view text) {
  std::uint32_t crc = ~0u;
  for (const char c : text) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (0xedb88320u & (0u - (crc & 1u)));
  }
  return ~crc;
}

// At most so many characters: "2.41", "12.4", ".120".
std::string short_number(const std::optional<double>& value, std::size_t most) {
  if (!value || !std::isfinite(*value)) return "-";
  const double largest = std::pow(10.0, static_cast<double>(most)) - 1.0;
  const double number = std::clamp(*value, most > 3 ? -99.0 : -9.0, largest);
  for (int decimals = static_cast<int>(most) - 1; decimals > 0; --decimals) {
    auto text = fmt::format("{:.{}f}", number, decimals);
    if (text.starts_with("0.")) text.erase(0, 1);
    if (text.size() <= most) return text;
  }
  return fmt::format("{:.0f}", number);
}

std::optional<double> number_in(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0; (at = text.find_first_not_of(' ', at)) != std::string_view::npos;) {
    const auto end = std::min(text.find(' ', at), text.size());
    words.push_back(text.substr(at, end - at));
    at = end;
  }
  return words;
}

}  // namespace

std::string history_text(const HistoryLine& line) {
  const auto utc = utc_text(line.utc);  // "2026-06-21T14:10:00Z"
  auto text = fmt::format("{:x} {}{}{}T{}{} {} {} {}", std::min(line.number, kLargestNumber), utc.substr(0, 4),
                          utc.substr(5, 2), utc.substr(8, 2), utc.substr(11, 2), utc.substr(14, 2), name_of(line.shown),
                          code_of(line.trouble), std::clamp(line.hidden_s, 0, 60));
  for (const auto& column : kHistoryColumns) text += " " + short_number(line.*column.value, column.digits);
  unsigned flags = 0;
  for (std::size_t i = 0; i < std::size(kHistoryFlags); ++i) flags |= unsigned{line.*kHistoryFlags[i].value} << i;
  text += fmt::format(" {}", flags);
  text.resize(kTextBytes, ' ');
  return text + fmt::format("{:08x}\n", checksum_of(text));
}

std::optional<HistoryLine> parse_history(std::string_view text) {
  if (text.size() != kHistoryLineBytes || text.back() != '\n') return std::nullopt;
  const auto body = text.substr(0, kTextBytes);
  if (text.substr(kTextBytes, kChecksumDigits) != fmt::format("{:08x}", checksum_of(body))) return std::nullopt;
  const auto words = words_of(body);
  constexpr std::size_t kBefore = 5, kNumbers = std::size(kHistoryColumns);
  if (words.size() != kBefore + kNumbers + 1) return std::nullopt;
  HistoryLine line;
  const auto& number = words[0];
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), line.number, 16);
  if (error != std::errc() || end != number.data() + number.size() || line.number > kLargestNumber) return std::nullopt;
  const auto& time = words[1];
  if (time.size() != 13) return std::nullopt;
  const auto utc = parse_utc(fmt::format("{}-{}-{}T{}:{}:00Z", time.substr(0, 4), time.substr(4, 2), time.substr(6, 2),
                                         time.substr(9, 2), time.substr(11, 2)));
  const auto shown = shown_named(words[2]);
  const auto trouble = trouble_coded(words[3]);
  const auto hidden = number_in(words[4]), flags = number_in(words.back());
  if (!utc || !shown || !trouble || !hidden || !flags || *hidden < 0.0 || *hidden > 60.0) return std::nullopt;
  line.utc = std::chrono::floor<std::chrono::minutes>(*utc);
  line.shown = *shown;
  line.trouble = *trouble;
  line.hidden_s = static_cast<int>(*hidden);
  for (std::size_t i = 0; i < kNumbers; ++i) line.*kHistoryColumns[i].value = number_in(words[kBefore + i]);
  for (std::size_t i = 0; i < std::size(kHistoryFlags); ++i)
    line.*kHistoryFlags[i].value = ((static_cast<int>(*flags) >> i) & 1) != 0;
  return line;
}

}  // namespace kasumi
