#include "pipeline/lab/prove/proof_json.hpp"

#include <cmath>

#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"

namespace kasumi {
namespace {

using Json = nlohmann::ordered_json;

// The double that prints with so many decimals.
Json rounded(double value, int decimals) {
  return std::isfinite(value) ? parse_ordered_json(fmt::format("{:.{}f}", value, decimals)) : Json(nullptr);
}
Json by_channel(const glm::dvec3& values, int decimals) {
  return {rounded(values.r, decimals), rounded(values.g, decimals), rounded(values.b, decimals)};
}
Json or_null(const std::optional<double>& value, int decimals) {
  return value ? rounded(*value, decimals) : Json(nullptr);
}

Json errors_json(const std::array<ErrorSummary, kProofWays.size()>& ways) {
  Json json;
  json["pictures"] = ways[0].pictures;
  for (std::size_t k = 0; k < ways.size(); ++k)
    json[std::string(name_of(kProofWays[k]))] = {{"error_median_255", rounded(ways[k].median_255, 2)},
                                                 {"error_p95_255", rounded(ways[k].p95_255, 2)},
                                                 {"error_mean_255", rounded(ways[k].mean_255, 2)}};
  return json;
}

Json picture_json(const Proof& proof, const ProofEntry& picture) {
  const auto& view = proof.scene.views[picture.view];
  Json json{{"file", view.file.string()},
            {"utc", view.utc ? Json(utc_text(*view.utc)) : Json(nullptr)},
            {"air_class", picture.air_class},
            {"left_out", picture.left_out.empty() ? Json(nullptr) : Json(picture.left_out)},
            {"measures_the_facade", picture.clear},
            {"lines_found", view.placed},
            {"moved_px", rounded(view.moved_px, 1)},
            {"blurred_share", rounded(view.blurred_share, 2)},
            {"sun_elevation_deg", or_null(picture.sun_elevation_deg, 1)},
            {"sun_azimuth_deg", or_null(picture.sun_azimuth_deg, 1)},
            {"sun_on_it_cosine", rounded(picture.sunlit, 3)}};
  if (picture.air.unknown.empty()) {
    json["extinction_per_m"] = by_channel(picture.air.per_m, 7);
    json["extinction_sigma_per_m"] = by_channel(picture.air.sigma_per_m, 7);
  }
  if (!picture.drawn) return json;
  json["seen_255"] = by_channel(picture.seen_255, 1);
  json["sigma_255"] = by_channel(picture.sigma_255, 1);
  for (const auto way : kProofWays) {
    json["drawn_255"][std::string(name_of(way))] = by_channel(picture.drawn_by(way), 1);
    json["error_255"][std::string(name_of(way))] = rounded(picture.error_255(way), 2);
  }
  json["pixel_error_255"] = rounded(picture.pixel_error_255, 2);
  return json;
}

}  // namespace

std::string proof_json(const Proof& proof, const ProofSummary& summary, const std::string& made_utc) {
  const auto& scene = proof.scene;
  Json json{{"made_utc", made_utc},
            {"part", scene.part.name},
            {"distance_m", scene.part.distance_m},
            {"reference", scene.reference.string()},
            {"unreadable_pictures", scene.unreadable}};
  json["others"] = Json::array();
  for (const auto& other : scene.others) json["others"].push_back(other.name);
  json["left_aside"] = scene.left_aside;
  json["facade"] = {{"shade_of_horizon", by_channel(proof.shade, 4)},
                    {"shade_sigma", by_channel(proof.shade_sigma, 4)},
                    {"lit_adds_of_horizon", proof.lit_views > 0 ? by_channel(proof.lit, 4) : Json(nullptr)},
                    {"shaded_pictures", proof.shaded_views},
                    {"lit_pictures", proof.lit_views}};
  json["fixed_t3_extinction_per_m"] = by_channel(proof.fixed_depth / scene.part.distance_m, 7);
  json["best_constant_extinction_per_m"] = by_channel(proof.constant_per_m, 7);
  json["errors"] = errors_json(summary.ways);
  json["errors"]["told_with_left_out"] = {{"pictures", summary.with_left_out.pictures},
                                          {"error_median_255", rounded(summary.with_left_out.median_255, 2)},
                                          {"error_p95_255", rounded(summary.with_left_out.p95_255, 2)}};
  json["bias_255"] = by_channel(summary.bias_255, 2);
  json["within_sigma_share"] = rounded(summary.within_sigma_share, 3);
  json["worst_sigmas"] = rounded(summary.worst_sigma, 1);
  json["pixel_error_median_255"] = rounded(summary.pixel_median_255, 2);
  json["classes"] = Json::object();
  for (const auto& one : summary.classes) json["classes"][one.air_class] = errors_json(one.ways);
  json["left_out"] = Json::object();
  for (const auto& [reason, count] : summary.left_out) json["left_out"][reason] = count;
  json["remarks"] = proof.remarks;
  json["pictures"] = Json::array();
  for (const auto& picture : proof.pictures) json["pictures"].push_back(picture_json(proof, picture));
  return text_of_json(json, 1) + "\n";
}

std::string remembered_proof(const Proof& proof, const ProofSummary& summary, const std::string& made_utc) {
  const Json json{{"made_utc", made_utc},
                  {"part", proof.scene.part.name},
                  {"pictures", summary.ways[0].pictures},
                  {"error_median_255", rounded(summary.ways[0].median_255, 2)},
                  {"error_p95_255", rounded(summary.ways[0].p95_255, 2)},
                  {"no_air_median_255", rounded(summary.ways[1].median_255, 2)}};
  return text_of_json(json, 1) + "\n";
}

std::string proof_text(const Proof& proof, const ProofSummary& summary) {
  const auto& scene = proof.scene;
  auto text = fmt::format("{} at {:.2f} km, put back into {} of {} pictures under the air that {} told\n",
                          scene.part.name, scene.part.distance_m / 1e3, summary.ways[0].pictures, proof.pictures.size(),
                          scene.others.empty() ? "a table" : fmt::format("{} other landmarks", scene.others.size()));
  const std::array<const char*, kProofWays.size()> words{"as told", "no air", "T = 3", "best constant"};
  for (std::size_t k = 0; k < words.size(); ++k)
    text += fmt::format("  {:<15}  off by {:.1f} of 255 in the median, {:.1f} at 95 %\n", words[k],
                        summary.ways[k].median_255, summary.ways[k].p95_255);
  if (summary.with_left_out.pictures > summary.ways[0].pictures)
    text +=
        fmt::format("  {:<15}  off by {:.1f} of 255 in the median, {:.1f} at 95 % ({} pictures)\n", "with all left out",
                    summary.with_left_out.median_255, summary.with_left_out.p95_255, summary.with_left_out.pictures);
  text += fmt::format("  bias             R {:+.1f}, G {:+.1f}, B {:+.1f}; within sigma {:.0f} % (68 expected)\n",
                      summary.bias_255.r, summary.bias_255.g, summary.bias_255.b, 100.0 * summary.within_sigma_share);
  text += fmt::format(
      "  its own light    R {:.3f}, G {:.3f}, B {:.3f} of the horizon's, in the shade of {} clear pictures\n",
      proof.shade.r, proof.shade.g, proof.shade.b, proof.shaded_views);
  for (const auto& one : summary.classes)
    text += fmt::format("  {:<15}  {} pictures: {:.1f}, {:.1f} at 95 %; without air {:.1f}\n", one.air_class,
                        one.ways[0].pictures, one.ways[0].median_255, one.ways[0].p95_255, one.ways[1].median_255);
  for (const auto& [reason, count] : summary.left_out)
    text += fmt::format("  left out         {}: {}\n", count, reason);
  for (const auto& remark : proof.remarks) text += fmt::format("  {}\n", remark);
  return text;
}

}  // namespace kasumi
