// What an archive comes to: its air and cloud by day, hour and season, and why pictures were refused. Memory grows with
// days, not with pictures' records.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "base/clock.hpp"

namespace kasumi {

struct Spread {
  double low = 0.0, median = 0.0, high = 0.0;  // 16, 50 and 84 % are below
};

// Values of pictures that belong together.
class Cell {
 public:
  void add_picture() { ++pictures_; }
  void add_aod(double value) { aods_.push_back(static_cast<float>(value)); }
  void add_cloud(double share) { cloud_ += share, ++clouds_; }
  void add(const Cell& other);
  std::size_t pictures() const { return pictures_; }
  std::size_t aods() const { return aods_.size(); }
  std::size_t clouds() const { return clouds_; }
  std::optional<Spread> aod() const;
  std::optional<double> cloud() const;  // mean share

 private:
  std::vector<float> aods_;
  double cloud_ = 0.0;
  std::size_t clouds_ = 0, pictures_ = 0;
};

class ArchiveFigures {
 public:
  // `ahead`: wall time of days and hours over UTC.
  explicit ArchiveFigures(std::chrono::minutes ahead) : ahead_(ahead) {}
  // Whatever the air of a night's picture may be, it is left out: its light is the moon's or a lamp's.
  void add(const nlohmann::json& record);

  std::size_t pictures() const { return pictures_; }
  std::size_t usable() const { return usable_; }
  std::size_t nights() const { return nights_; }        // usable but for the sun, which was below the horizon
  std::size_t exposures() const { return exposures_; }  // of stacks, beside the one that has the stack's answer
  std::size_t timeless() const { return timeless_; }    // pictures without a time, in no day
  const std::optional<Utc>& first() const { return first_; }
  const std::optional<Utc>& last() const { return last_; }
  std::chrono::minutes ahead() const { return ahead_; }
  const std::map<std::chrono::sys_days, Cell>& days() const { return days_; }
  const Cell& at(std::size_t month, std::size_t hour) const { return hours_[month][hour]; }  // month from 0
  Cell month(std::size_t month) const;
  // Pictures whose air is known with the sun there: by 10 deg of height, by 15 deg of azimuth from north.
  std::size_t suns(std::size_t height, std::size_t azimuth) const { return suns_[height][azimuth]; }
  // Why, and how many, the most frequent first.
  std::vector<std::pair<std::string, std::size_t>> refusals() const;

 private:
  std::chrono::minutes ahead_;
  std::size_t pictures_ = 0, usable_ = 0, timeless_ = 0, nights_ = 0, exposures_ = 0;
  std::optional<Utc> first_, last_;
  std::map<std::chrono::sys_days, Cell> days_;
  std::array<std::array<Cell, 24>, 12> hours_;
  std::array<std::array<std::size_t, 24>, 9> suns_{};
  std::map<std::string, std::size_t> refusals_;
};

}  // namespace kasumi
