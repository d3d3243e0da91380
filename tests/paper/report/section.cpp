#include "tests/paper/report/section.hpp"

#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "base/files.hpp"
#include "pipeline/site/files/html.hpp"

namespace kasumi::paper {
namespace {

constexpr std::string_view kStyle = R"(
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, "DejaVu Sans", sans-serif; color: #222; background: #fff; margin: 0 auto; max-width: 66rem; padding: 1rem; }
h1 { font-size: 1.7rem; margin: 0 0 .3rem; } h2 { font-size: 1.3rem; margin: 2.6rem 0 .4rem; border-bottom: 2px solid #888; }
p { margin: .4rem 0; max-width: 52rem; } nav ul { margin: .5rem 0; padding-left: 1.2rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; margin: .8rem 0; }
th, td { text-align: left; padding: .25rem .9rem .25rem 0; border-bottom: 1px solid #ddd; font-variant-numeric: tabular-nums; vertical-align: top; }
th { font-size: .85rem; color: #555; font-weight: normal; vertical-align: bottom; }
svg { display: block; width: 100%; max-width: 44rem; height: auto; margin: .8rem 0; }
figure { margin: .8rem 0; } figcaption { color: #555; font-size: .9rem; max-width: 52rem; } img { display: block; max-width: 100%; height: auto; }
.finding { border-left: 5px solid; padding: .1rem .8rem; margin: .6rem 0; max-width: 52rem; }
.reproduced, .better { border-color: #14692c; } .differs { border-color: #b36b00; } .skipped { border-color: #888; }
@media print { body { max-width: none; font-size: 10pt; } h2, figure, svg, tr { break-inside: avoid; } }
)";

}  // namespace

std::string_view name_of(Finding finding) {
  switch (finding) {
    case Finding::reproduced: return "reproduced";
    case Finding::better: return "better";
    case Finding::differs: return "differs";
    case Finding::skipped: break;
  }
  return "skipped";
}

void Section::say(std::string_view text) {
  body_ += fmt::format("<p>{}</p>\n", html_escaped(text));
}

void Section::table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows) {
  body_ += "<div class=\"scroll\"><table><thead><tr>";
  for (const auto& cell : head) body_ += fmt::format("<th>{}</th>", html_escaped(cell));
  body_ += "</tr></thead><tbody>\n";
  for (const auto& row : rows) {
    body_ += "<tr>";
    for (const auto& cell : row) body_ += fmt::format("<td>{}</td>", html_escaped(cell));
    body_ += "</tr>\n";
  }
  body_ += "</tbody></table></div>\n";
}

void Section::plot(const Plot& plot) {
  body_ += svg_of(plot);
}

void Section::picture(const Image<Rgb8>& picture, std::string_view caption, int shown_px) {
  cv::Mat matrix(picture.height(), picture.width(), CV_8UC3);
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const auto& pixel = picture.at(x, y);
      matrix.at<cv::Vec3b>(y, x) = {pixel.b, pixel.g, pixel.r};
    }
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", matrix, bytes, {cv::IMWRITE_JPEG_QUALITY, 92});
  body_ += fmt::format("<figure><img width=\"{}\" alt=\"{}\" src=\"{}\"><figcaption>{}</figcaption></figure>\n",
                       std::min(shown_px, picture.width()), html_escaped(caption), data_uri("image/jpeg", bytes),
                       html_escaped(caption));
}

void Section::finding(Finding finding, std::string_view words) {
  findings_.emplace_back(finding, std::string(words));
  body_ += fmt::format("<p class=\"finding {0}\"><b>{0}</b>: {1}</p>\n", name_of(finding), html_escaped(words));
}

std::vector<Section> all_sections(const ReportOptions& options, const std::function<void(const Section&)>& done) {
  std::vector<Section> sections;
  for (const auto make : {turbidity_section, sky_pictures_section, scattering_section, terms_section, scenes_section,
                          mixed_reality_section, photographs_section, classic_section, landmarks_section, haze_section,
                          haze_pictures_section, report_u_section, frame_rate_section}) {
    sections.push_back(make(options));
    if (done) done(sections.back());
  }
  return sections;
}

Result<> write_report(const std::filesystem::path& folder, const std::vector<Section>& sections,
                      const ReportOptions& options) {
  std::string page = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<title>The papers again</title>\n<style>{}</style>\n</head>\n"
      "<body>\n<h1>The papers again</h1>\n"
      "<p>Tables and figures of the papers that Kasumi builds on, next to its own results, all computed by the command "
      "that wrote this page. M: Morales, Oishi, Ikeuchi 2017; M14: Morales et al. 2014; H: Hansard, Fast synthesis of "
      "atmospheric image effects; P: the poster of M14; U: the report of Universiti Teknologi Malaysia. Where a figure "
      "of theirs does not come out again, the page says so and why.</p>\n{}<nav><ul>\n",
      kStyle,
      options.quick
          ? "<p class=\"finding differs\"><b>quick</b>: made with few repeats and small pictures, to check that it "
            "works; its figures are not meaningful.</p>\n"
          : "");
  nlohmann::json figures;
  for (const auto& section : sections) {
    std::string verdicts;
    for (const auto& [finding, words] : section.findings())
      verdicts += fmt::format("{}{}", verdicts.empty() ? ": " : ", ", name_of(finding));
    page += fmt::format("<li><a href=\"#{}\">{}</a>{}</li>\n", section.id(), html_escaped(section.title()), verdicts);
    auto& own = figures[section.id()];
    own["figures"] = section.figures();
    own["findings"] = nlohmann::json::array();
    for (const auto& [finding, words] : section.findings())
      own["findings"].push_back({{"finding", name_of(finding)}, {"words", words}});
  }
  page += "</ul></nav>\n";
  for (const auto& section : sections)
    page += fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n{}</section>\n", section.id(), html_escaped(section.title()),
                        section.body());
  page += "</body>\n</html>\n";
  if (auto done = write_text_file(folder / "figures.json", figures.dump(2) + "\n"); !done) return done;
  return write_text_file(folder / "index.html", page);
}

}  // namespace kasumi::paper
