// Records of an archive, as `kasumi estimate --out` writes them, of skies that are made up: a day in which the sun is
// up from 6 to 18 h, a third of the days overcast, the air hazier in summer.
#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include <fmt/format.h>

#include "base/utc_text.hpp"
#include "pipeline/lab/archive/archive_record.hpp"

namespace kasumi {

class MadeArchive {
 public:
  explicit MadeArchive(std::size_t pictures) : archive_{pictures, "0123456789abcdef", "fedcba9876543210"} {}
  const Archive& archive() const { return archive_; }

  // `number`: from 1; ten minutes after the one before.
  std::string record(std::size_t number) const {
    const auto utc = *parse_utc("2025-01-01T00:00:00Z") + std::chrono::minutes(10 * (number - 1));
    const auto of_day = (number - 1) % 144, day = (number - 1) / 144;
    const auto image = fmt::format("sky/{:06}.jpg", number);
    const ArchivePlace place{number, archive_};
    if (number % 997 == 0) return unread_record(image, utc, image + ": no picture", place);
    const bool night = of_day < 36 || of_day >= 108, overcast = day % 3 == 1;
    const double aod = 0.15 + 0.1 * std::sin((static_cast<double>(day) - 80.0) / 365.0 * 2.0 * std::numbers::pi) +
                       0.02 * std::sin(static_cast<double>(number));
    const char* verdict = night ? "night" : overcast ? "overcast" : "clear";
    const auto answer = fmt::format(
        R"({{"image":"{}","turbidity":{},"sigma":0.2,"usable":{},"reason":"","sky":"{}","cloud_fraction":{},)"
        R"("verdict":"{}","aod_550":{},"models":[{{"name":"dome continental","turbidity":2.5,"aod_550":0.15}}]}})",
        image, night || overcast ? "null" : "2.5", !night && !overcast, verdict,
        night ? "null" : (overcast ? "0.95" : "0.1"), verdict, night || overcast ? "null" : fmt::format("{:.4f}", aod));
    return archive_record(answer, utc, night || overcast ? verdict : "", place);
  }
  // Records from `first` (from 1) to `last`.
  std::string records(std::size_t first, std::size_t last) const {
    std::string text;
    for (std::size_t i = first; i <= last; ++i) text += record(i);
    return text;
  }
  void write(const std::filesystem::path& file, std::size_t first, std::size_t last) const {
    std::ofstream(file, std::ios::binary) << records(first, last);
  }

 private:
  Archive archive_;
};

}  // namespace kasumi
