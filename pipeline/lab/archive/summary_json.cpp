#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"
#include "pipeline/lab/archive/summary_page.hpp"

namespace kasumi {
namespace {

using Json = nlohmann::ordered_json;

double in_parts_of_a_million(double value) {
  return std::round(value * 1e6) / 1e6;
}

Json json_of_trend(const ArchiveFigures& figures) {
  const auto trend = trend_of(monthly_aod(figures));
  if (!trend) return {{"per_year", nullptr}, {"reason", trend.error().message}};
  return {{"per_year", in_parts_of_a_million(trend->per_year)},
          {"sigma_per_year", in_parts_of_a_million(trend->sigma)},
          {"level", in_parts_of_a_million(trend->level)},
          {"months", trend->months},
          {"autocorrelation", in_parts_of_a_million(trend->autocorrelation)},
          {"sigma_month", in_parts_of_a_million(trend->sigma_month)}};
}

Json json_of_months(const SeriesFigures& series) {
  auto months = Json::array();
  for (const auto& [number, month] : series.months()) {
    Json each;
    each["month"] = fmt::format("{:04}-{:02}", number / 12, number % 12 + 1);
    each["pictures"] = month.pictures();
    each["air_known"] = month.count(EstimateFate::air_known);
    each["cloudy"] = month.count(EstimateFate::cloudy);
    each["sun_too_low"] = month.count(EstimateFate::sun_too_low);
    each["night"] = month.count(EstimateFate::night);
    each["other"] = month.count(EstimateFate::other);
    each["sun_off_deg"] = nullptr;
    if (const auto off = month.sun_off_deg()) each["sun_off_deg"] = in_parts_of_a_million(*off);
    each["circle_radius_px"] = nullptr;
    if (const auto radius = month.radius_px()) each["circle_radius_px"] = in_parts_of_a_million(*radius);
    months.push_back(std::move(each));
  }
  return months;
}

Json json_of_photometer(const PhotometerComparison& comparison) {
  const auto all = comparison.agreement();
  Json json{{"readings", comparison.readings()}, {"pairs", all.pairs}};
  if (all.pairs == 0) return json;
  json["bias"] = in_parts_of_a_million(all.bias);
  json["rmse"] = in_parts_of_a_million(all.rmse);
  json["scatter"] = in_parts_of_a_million(all.scatter);
  json["within_expected_error"] = in_parts_of_a_million(all.within_expected);
  return json;
}

}  // namespace

std::string summary_json(const ArchiveSummary& summary) {
  const auto& figures = summary.figures;
  Json json;
  json["pictures"] = figures.pictures();
  json["air_known"] = figures.usable();
  json["first_utc"] = nullptr;
  json["last_utc"] = nullptr;
  if (figures.first()) json["first_utc"] = utc_text(*figures.first());
  if (figures.last()) json["last_utc"] = utc_text(*figures.last());
  json["left_out_by_night"] = figures.nights();
  json["exposures_of_stacks"] = figures.exposures();
  json["trend_aod_550"] = json_of_trend(figures);
  json["photometer"] = nullptr;
  if (summary.photometer) json["photometer"] = json_of_photometer(*summary.photometer);
  json["months"] = json_of_months(summary.series);
  return text_of_json(json, 2) + "\n";
}

}  // namespace kasumi
