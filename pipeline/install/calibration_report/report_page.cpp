#include <fmt/format.h>

#include "pipeline/install/calibration_report/report.hpp"
#include "pipeline/site/files/html.hpp"

namespace kasumi {

namespace {

// Readable on a phone (each row becomes a card) and on paper. Verdicts carry a sign, because paper may be grey.
constexpr std::string_view kStyle = R"(
:root { color-scheme: light; }
body { font: 16px/1.45 system-ui, "DejaVu Sans", sans-serif; color: #222; background: #fff; margin: 0 auto; max-width: 62rem; padding: 1rem; }
h1 { font-size: 1.6rem; margin: 0 0 .3rem; } h2 { font-size: 1.35rem; margin: 2.2rem 0 .3rem; border-bottom: 2px solid #888; }
h3 { font-size: 1.1rem; margin: 1.8rem 0 .3rem; }
p { margin: .3rem 0; } .quiet { color: #555; font-size: .9rem; overflow-wrap: anywhere; }
table { border-collapse: collapse; width: 100%; margin: .6rem 0; }
th, td { text-align: left; vertical-align: top; padding: .3rem .6rem .3rem 0; border-bottom: 1px solid #ddd; }
th { font-size: .85rem; color: #555; font-weight: normal; }
td.number { white-space: nowrap; font-variant-numeric: tabular-nums; }
.good { color: #14692c; } .usable { color: #8a5a00; } .poor { color: #b3201a; font-weight: bold; }
img { display: block; max-width: 100%; height: auto; margin: .8rem 0; border: 1px solid #ddd; }
ul { margin: .4rem 0; padding-left: 1.3rem; } li { margin: .15rem 0; overflow-wrap: anywhere; }
code, pre { font-family: "DejaVu Sans Mono", monospace; font-size: .85rem; } pre { white-space: pre-wrap; overflow-wrap: anywhere; }
@media (max-width: 40rem) {
  thead { display: none; }
  tr { display: block; padding: .4rem 0; border-bottom: 1px solid #ccc; }
  td { display: block; border: 0; padding: 0; white-space: normal; }
  td:empty { display: none; }
  td[data-is]::before { content: attr(data-is) ": "; color: #555; font-size: .85rem; }
  td.number { white-space: normal; }
}
@media print {
  body { font-size: 10.5pt; max-width: none; padding: 0; }
  h2 { break-before: page; } h2.first { break-before: auto; }
  h3, tr, img, li { break-inside: avoid; } h3 { break-after: avoid; }
  img { max-height: 20cm; } details { display: none; }
}
)";

std::string_view class_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::good: return "good";
    case Verdict::usable: return "usable";
    case Verdict::poor: break;
  }
  return "poor";
}
std::string_view sign_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::good: return "\xe2\x9c\x93";
    case Verdict::usable: return "~";
    case Verdict::poor: break;
  }
  return "\xe2\x9c\x97";
}

// "2026-06-21T09:00:00Z" as "2026-06-21 09:00:00 UTC".
std::string readable(std::string utc) {
  if (utc.size() < 20 || utc[10] != 'T' || utc.back() != 'Z') return utc;
  utc[10] = ' ';
  utc.pop_back();
  return utc + " UTC";
}

void add_row(PageText& page, const ReportRow& row) {
  page.add("<tr><td>{}</td><td class=\"number\">{}</td>", html_escaped(row.label), html_escaped(row.value));
  page.add("<td class=\"number\" data-is=\"sigma\">{}</td><td class=\"number\" data-is=\"should be\">{}</td>",
           html_escaped(row.sigma), html_escaped(row.should_be));
  if (row.verdict)
    page.add("<td class=\"{}\">{} {}{}</td>", class_of(*row.verdict), sign_of(*row.verdict), name_of(*row.verdict),
             row.remedy.empty() ? "" : ": " + html_escaped(row.remedy));
  else
    page.add("<td></td>");
  page.add("</tr>\n");
}

void add_step(PageText& page, const ReportSection& camera, const ReportStep& step) {
  page.add("<h3>{}</h3>\n", html_escaped(step.title));
  if (!step.utc.empty()) page.add("<p>Measured {}.</p>\n", html_escaped(readable(step.utc)));
  if (!step.from.empty()) page.add("<p class=\"quiet\">From {}.</p>\n", html_escaped(step.from));
  if (!step.rows.empty()) {
    page.add(
        "<table><thead><tr><th></th><th>value</th><th>sigma</th><th>should be</th><th></th></tr>"
        "</thead><tbody>\n");
    for (const auto& row : step.rows) add_row(page, row);
    page.add("</tbody></table>\n");
  }
  if (!step.remarks.empty()) {
    page.add("<ul>\n");
    for (const auto& remark : step.remarks) page.add("<li>{}</li>\n", html_escaped(remark));
    page.add("</ul>\n");
  }
  if (!step.picture.empty())
    page.add("<img alt=\"{}\" src=\"{}\">\n",
             html_escaped(fmt::format("{} of the {} camera: {}", step.title, camera.name, step.picture_name)),
             data_uri("image/png", step.picture));
  else if (!step.picture_name.empty())
    page.add("<p class=\"usable\">The plot of this step, {}, is no longer next to the calibration file.</p>\n",
             html_escaped(step.picture_name));
}

struct Count {
  int good = 0, usable = 0, poor = 0;
};
Count count_of(const ReportSection& camera) {
  Count count;
  for (const auto& step : camera.steps)
    for (const auto& row : step.rows)
      if (row.verdict)
        ++(*row.verdict == Verdict::good ? count.good : *row.verdict == Verdict::usable ? count.usable : count.poor);
  return count;
}

void add_camera(PageText& page, const ReportSection& camera, const std::string& calibration, bool first) {
  page.add("<h2{}>The {} camera</h2>\n", first ? " class=\"first\"" : "", html_escaped(camera.name));
  if (!camera.description.empty()) page.add("<p class=\"quiet\">{}</p>\n", html_escaped(camera.description));
  if (camera.steps.empty()) {
    page.add("<p class=\"poor\">Nothing has been measured yet.</p>\n");
  } else {
    const auto count = count_of(camera);
    page.add("<p>{} numbers are good, {} usable, {} not good enough.</p>\n", count.good, count.usable, count.poor);
  }
  if (!camera.missing.empty()) {
    page.add("<p><b>Still to be done:</b></p>\n<ul>\n");
    for (const auto& step : camera.missing)
      page.add("<li>{}: {}<br><code>{} {}</code></li>\n", html_escaped(step.title), html_escaped(step.missing),
               html_escaped(step.command), html_escaped(calibration));
    page.add("</ul>\n");
  }
  for (const auto& step : camera.steps) add_step(page, camera, step);
}

}  // namespace

std::string html_of(const CalibrationReport& report, const std::string& made_utc) {
  PageText page;
  page.add(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>Calibration: {}</title>\n<style>{}</style>\n</head>\n<body>\n",
      html_escaped(report.name), kStyle);
  page.add("<h1>Calibration of the cameras</h1>\n<p class=\"quiet\">{}, as it was on {}</p>\n",
           html_escaped(report.name), html_escaped(readable(made_utc)));
  if (!report.site.empty()) page.add("<p class=\"quiet\">{}</p>\n", html_escaped(report.site));
  bool first = true;
  for (const auto& camera : report.cameras) {
    add_camera(page, camera, report.name, first);
    first = false;
  }
  page.add("<details><summary>The file itself</summary><pre>{}</pre></details>\n</body>\n</html>\n",
           html_escaped(report.file));
  return std::move(page).text();
}

}  // namespace kasumi
