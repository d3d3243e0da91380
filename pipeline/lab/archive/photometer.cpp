#include "pipeline/lab/archive/photometer.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "base/files.hpp"
#include "base/finite_number.hpp"
#include "base/utc_text.hpp"

namespace kasumi {
namespace {

constexpr double kWanted_nm = 550.0, kShortest_nm = 400.0, kLongest_nm = 900.0;

std::vector<std::string> cells_of(std::string_view line) {
  std::vector<std::string> cells;
  if (line.ends_with('\r')) line.remove_suffix(1);
  for (std::size_t begin = 0; begin <= line.size();) {
    const auto end = std::min(line.find(',', begin), line.size());
    cells.emplace_back(line.substr(begin, end - begin));
    begin = end + 1;
  }
  return cells;
}

struct PhotometerChannel {
  std::size_t column;
  double wavelength_nm;
};

// "AOD_500nm", and where it stands.
std::vector<PhotometerChannel> channels_of(const std::vector<std::string>& names) {
  std::vector<PhotometerChannel> channels;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string_view name = names[i];
    if (!name.starts_with("AOD_") || !name.ends_with("nm")) continue;
    const auto wavelength = finite_number(std::string(name.substr(4, name.size() - 6)));
    if (wavelength && *wavelength >= kShortest_nm && *wavelength <= kLongest_nm) channels.push_back({i, *wavelength});
  }
  return channels;
}

// Of "21:06:2025" and "09:30:00".
std::optional<Utc> utc_of(const std::string& date, const std::string& time) {
  if (date.size() != 10 || date[2] != ':' || date[5] != ':') return std::nullopt;
  return parse_utc(fmt::format("{}-{}-{}T{}Z", date.substr(6), date.substr(3, 2), date.substr(0, 2), time));
}

void read_table(const std::filesystem::path& file, std::vector<PhotometerReading>& readings, Problems& problems) {
  const auto text = read_text_file(file, {.or_pipe = true});
  if (!text) return problems.add("--photometer {}", text.error().message);
  std::vector<PhotometerChannel> channels;
  std::size_t date = 0, time = 0, columns = 0;
  int number = 0;
  for (std::size_t begin = 0; begin < text->size();) {
    const auto end = std::min(text->find('\n', begin), text->size());
    const auto cells = cells_of(std::string_view(*text).substr(begin, end - begin));
    begin = end + 1;
    ++number;
    if (columns == 0) {
      const auto at = [&](std::string_view name) {
        return static_cast<std::size_t>(std::ranges::find(cells, name) - cells.begin());
      };
      date = at("Date(dd:mm:yyyy)"), time = at("Time(hh:mm:ss)");
      if (date < cells.size() && time < cells.size()) {
        columns = cells.size();
        channels = channels_of(cells);
      }
      continue;
    }
    if (cells.size() == 1 && cells.front().empty()) continue;
    const auto utc = std::max(date, time) < cells.size() ? utc_of(cells[date], cells[time]) : std::optional<Utc>();
    if (!utc)
      return problems.add("--photometer {}: line {}: no date like 21:06:2025 and time like 09:30:00 in their columns",
                          file.string(), number);
    std::vector<ChannelDepth> depths;
    for (const auto& channel : channels) {
      const auto depth = channel.column < cells.size() ? finite_number(cells[channel.column]) : std::nullopt;
      if (!depth)
        return problems.add("--photometer {}: line {}: AOD_{:g}nm: expected a number, -999 where there is none",
                            file.string(), number, channel.wavelength_nm);
      if (*depth > 0.0) depths.push_back({channel.wavelength_nm, *depth});
    }
    if (const auto aod = aod_at_550(depths)) readings.push_back({*utc, *aod});
  }
  if (columns == 0 || channels.empty())
    problems.add(
        "--photometer {}: expected a table of AERONET, version 3: columns Date(dd:mm:yyyy), Time(hh:mm:ss) and "
        "AOD_500nm or the like",
        file.string());
}

}  // namespace

std::optional<double> aod_at_550(const std::vector<ChannelDepth>& channels) {
  const auto shorter = [](const ChannelDepth& channel) { return channel.wavelength_nm <= kWanted_nm; };
  const auto longer = [](const ChannelDepth& channel) { return channel.wavelength_nm >= kWanted_nm; };
  if (channels.size() < 2 || std::ranges::none_of(channels, shorter) || std::ranges::none_of(channels, longer))
    return std::nullopt;
  const int unknowns = channels.size() > 2 ? 3 : 2;
  cv::Mat design(static_cast<int>(channels.size()), unknowns, CV_64F), depths(design.rows, 1, CV_64F), law;
  for (int i = 0; i < design.rows; ++i) {
    const auto& channel = channels[static_cast<std::size_t>(i)];
    const double x = std::log(channel.wavelength_nm / kWanted_nm);
    for (int power = 0; power < unknowns; ++power) design.at<double>(i, power) = std::pow(x, power);
    depths.at<double>(i) = std::log(channel.aod);
  }
  if (!cv::solve(design, depths, law, cv::DECOMP_SVD)) return std::nullopt;
  return std::exp(law.at<double>(0));
}

Result<std::vector<PhotometerReading>> read_photometer(const std::vector<std::filesystem::path>& files) {
  std::vector<PhotometerReading> readings;
  Problems problems;
  for (const auto& file : files) read_table(file, readings, problems);
  if (!problems.empty()) return fail(problems.fault());
  std::ranges::sort(readings, {}, &PhotometerReading::utc);
  return readings;
}

void PhotometerComparison::add(const nlohmann::json& record) {
  constexpr std::chrono::minutes kNear{15};
  const auto value = [&](const char* key) { return record.contains(key) ? record[key] : nlohmann::json(); };
  const auto aod = value("aod_550"), time = value("utc");
  if (!aod.is_number() || !time.is_string() || !value("refused").is_null()) return;
  const auto zenith = value("sun_zenith_deg");
  if (zenith.is_number() && zenith.get<double>() > 90.0) return;
  const auto utc = parse_utc(time.get<std::string>());
  if (!utc) return;
  const auto after = std::ranges::lower_bound(readings_, *utc, {}, &PhotometerReading::utc);
  const PhotometerReading* nearest = nullptr;
  if (after != readings_.end()) nearest = &*after;
  if (after != readings_.begin() && (!nearest || *utc - (after - 1)->utc <= nearest->utc - *utc))
    nearest = &*(after - 1);
  if (!nearest || std::chrono::abs(nearest->utc - *utc) > kNear) return;
  pairs_.push_back({aod.get<float>(), static_cast<float>(nearest->aod_550)});
}

PhotometerAgreement PhotometerComparison::agreement() const {
  PhotometerAgreement all;
  all.pairs = pairs_.size();
  if (pairs_.empty()) return all;
  const auto count = static_cast<double>(pairs_.size());
  double sum = 0.0, squares = 0.0;
  std::size_t within = 0;
  for (const auto& pair : pairs_) {
    const double measured = double{pair.photometer}, off = double{pair.camera} - measured;
    sum += off;
    squares += off * off;
    within += std::abs(off) <= 0.05 + 0.15 * measured ? 1 : 0;
  }
  all.bias = sum / count;
  all.rmse = std::sqrt(squares / count);
  all.scatter = count > 1.0 ? std::sqrt(std::max(0.0, (squares - sum * sum / count) / (count - 1.0))) : 0.0;
  all.within_expected = static_cast<double>(within) / count;
  return all;
}

}  // namespace kasumi
