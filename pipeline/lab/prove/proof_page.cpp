#include "pipeline/lab/prove/proof_page.hpp"

#include <fmt/format.h>

#include "pipeline/lab/prove/proof_plots.hpp"
#include "pipeline/site/files/html.hpp"

namespace kasumi {
namespace {

constexpr std::string_view kProofStyle = R"(
:root { color-scheme: light; }
body { font: 16px/1.45 system-ui, "DejaVu Sans", sans-serif; color: #222; background: #fff; margin: 0 auto; max-width: 66rem; padding: 1rem; }
h1 { font-size: 1.6rem; margin: 0 0 .3rem; } h2 { font-size: 1.25rem; margin: 2rem 0 .3rem; border-bottom: 2px solid #888; }
p { margin: .4rem 0; } .quiet { color: #555; font-size: .9rem; overflow-wrap: anywhere; } .lead { font-size: 1.15rem; }
.scroll { overflow-x: auto; } table { border-collapse: collapse; margin: .6rem 0; }
th, td { text-align: right; padding: .25rem .8rem .25rem 0; border-bottom: 1px solid #ddd; font-variant-numeric: tabular-nums; }
th { font-size: .85rem; color: #555; font-weight: normal; } th:first-child, td:first-child { text-align: left; }
svg { width: 100%; max-width: 48rem; height: auto; } img { display: block; max-width: 100%; height: auto; margin: .8rem 0; }
@media print { body { font-size: 10.5pt; max-width: none; padding: 0; } h2, svg, img { break-inside: avoid; } }
)";

void add_errors_row(PageText& page, const std::string& name, const std::array<ErrorSummary, kProofWays.size()>& ways) {
  page.add("<tr><td>{}</td><td>{}</td>", html_escaped(name), ways[0].pictures);
  for (const auto& way : ways) page.add("<td>{:.1f}</td><td>{:.1f}</td>", way.median_255, way.p95_255);
  page.add("</tr>\n");
}

void add_errors(PageText& page, const ProofSummary& summary) {
  page.add(
      "<h2>How far off it is drawn</h2>\n<p class=\"quiet\">Of 255, the mean of the three channels; median, and what "
      "95 % "
      "of the pictures stay below.</p>\n<div class=\"scroll\"><table><thead><tr><th></th><th>pictures</th>"
      "<th>air told</th><th>95 %</th><th>no air</th><th>95 %</th><th>T = 3</th><th>95 %</th><th>best constant</th>"
      "<th>95 %</th></tr></thead><tbody>\n");
  add_errors_row(page, "all", summary.ways);
  for (const auto& one : summary.classes) add_errors_row(page, one.air_class, one.ways);
  page.add("</tbody></table></div>\n");
}

void add_left_out(PageText& page, const Proof& proof, const ProofSummary& summary) {
  if (summary.left_out.empty()) return;
  page.add(
      "<h2>Left out</h2>\n<p>Drawn all the same, they and the others together are off by {:.1f} in the median and "
      "{:.1f} "
      "at 95 %.</p>\n<ul>\n",
      summary.with_left_out.median_255, summary.with_left_out.p95_255);
  for (const auto& [reason, count] : summary.left_out) page.add("<li>{}: {}</li>\n", count, html_escaped(reason));
  page.add("</ul>\n<details><summary>Each of them</summary><ul>\n");
  for (const auto& picture : proof.pictures)
    if (!picture.left_out.empty())
      page.add("<li>{}: {}</li>\n", html_escaped(proof.scene.views[picture.view].file.filename().string()),
               html_escaped(picture.left_out));
  page.add("</ul></details>\n");
}

std::string names_of(const std::vector<ContrastLandmark>& landmarks) {
  std::string names;
  for (const auto& landmark : landmarks) names += (names.empty() ? "" : ", ") + landmark.name;
  return names;
}

}  // namespace

std::string proof_page(const Proof& proof, const ProofSummary& summary, std::span<const std::uint8_t> sheet,
                       const std::string& made_utc) {
  const auto& scene = proof.scene;
  const auto name = html_escaped(scene.part.name);
  PageText page;
  page.add(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>Proof: {}</title>\n"
      "<style>{}</style>\n</head>\n<body>\n<h1>{}, put back into its own pictures</h1>\n",
      name, kProofStyle, name);
  page.add("<p class=\"quiet\">{:.2f} km away; {} pictures, {} judged; made {}</p>\n", scene.part.distance_m / 1e3,
           proof.pictures.size(), summary.ways[0].pictures, html_escaped(made_utc));
  page.add(
      "<p class=\"lead\">Drawn under the air that others tell, it is off by <b>{:.1f} of 255</b> in the median and by "
      "{:.1f} at 95 %. Without air it would be {:.1f} and {:.1f}.</p>\n",
      summary.ways[0].median_255, summary.ways[0].p95_255, summary.ways[1].median_255, summary.ways[1].p95_255);
  page.add(
      "<p>Its facade was measured pixel by pixel in {} clear pictures in which the sun does not reach it{}, each time "
      "on "
      "other days than the picture's own: it returns {:.3f}, {:.3f}, {:.3f} (red, green, blue) of the horizon's light "
      "in the shade. The air before it is told by {}; it is not asked itself{}.</p>\n",
      proof.shaded_views, proof.lit_views > 0 ? fmt::format(", and in {} in which it does", proof.lit_views) : "",
      proof.shade.r, proof.shade.g, proof.shade.b,
      scene.others.empty() ? "a table" : html_escaped(names_of(scene.others)),
      scene.left_aside.size() > 1 ? ", nor is what belongs to the same building" : "");
  page.add(
      "<p>Bias (drawn - seen): red {:+.1f}, green {:+.1f}, blue {:+.1f} of 255. {:.0f} % are within one sigma (of "
      "normal "
      "errors 68 %), the worst at {:.1f}. Single pixels are off by {:.1f}.</p>\n",
      summary.bias_255.r, summary.bias_255.g, summary.bias_255.b, 100.0 * summary.within_sigma_share,
      summary.worst_sigma, summary.pixel_median_255);
  for (const auto& remark : proof.remarks) page.add("<p>{}</p>\n", html_escaped(remark));
  add_errors(page, summary);
  page.add("<h2>Seen and drawn</h2>\n{}{}<h2>Over the air</h2>\n{}", plot_drawn_over_seen(proof), plot_over_time(proof),
           plot_errors_over_extinction(proof));
  add_left_out(page, proof, summary);
  if (!sheet.empty())
    page.add(
        "<h2>As seen | as drawn | difference</h2>\n<p class=\"quiet\">From the clearest air to the thickest. The "
        "difference (drawn - seen) is four times as large, on grey.</p>\n<img alt=\"Contact sheet\" src=\"{}\">\n",
        data_uri("image/png", sheet));
  page.add("</body>\n</html>\n");
  return std::move(page).text();
}

}  // namespace kasumi
