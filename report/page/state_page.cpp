#include "report/page/state_page.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/status/status_figures.hpp"
#include "base/words/texts.hpp"
#include "history/history_plot.hpp"
#include "report/diagnosis/symptom_words.hpp"
#include "report/page/bitmap.hpp"

namespace kasumi::report {

namespace {

using std::chrono::minutes;

constexpr minutes kDay{24 * 60};
constexpr std::size_t kMostSpells = 40;
constexpr int kScreenShown_px = 160;  // along the longer side: the browser enlarges it softly

std::string escaped(std::string_view text) {
  std::string safe;
  for (const char c : text) switch (c) {
      case '&': safe += "&amp;"; break;
      case '<': safe += "&lt;"; break;
      case '>': safe += "&gt;"; break;
      case '"': safe += "&quot;"; break;
      case '\'': safe += "&#39;"; break;
      default: safe += c;
    }
  return safe;
}

std::string wall_time(UtcMinute utc, minutes wall) {
  const auto local = utc + wall;
  const auto day = std::chrono::floor<std::chrono::days>(local);
  const std::chrono::year_month_day date{day};
  const auto of_day = local - day;
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02}", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), of_day / minutes{60},
                     (of_day % minutes{60}).count());
}

// With the zone: whoever reads it may sit in another.
std::string wall_stamp(UtcMinute utc, minutes wall) {
  if (wall == minutes{0}) return wall_time(utc, wall) + " UTC";
  const auto off = std::chrono::abs(wall);
  auto zone = fmt::format(" UTC{}{}", wall < minutes{0} ? '-' : '+', off / minutes{60});
  if (off % minutes{60} != minutes{0}) zone += fmt::format(":{:02}", (off % minutes{60}).count());
  return wall_time(utc, wall) + zone;
}

// What a rung meant for visitors, as the page words it now.
Sight sight_of_spell(const Spell& spell) {
  switch (spell.shown) {
    case Shown::live: return Sight::live;
    case Shown::held: return Sight::held;
    case Shown::degraded: return spell.trouble == Trouble::time_unknown ? Sight::no_building : Sight::earlier_air;
    case Shown::still:
      return spell.trouble == Trouble::safe_mode || spell.trouble == Trouble::content_refused ? Sight::out_of_order
                                                                                              : Sight::still;
    case Shown::dark: return Sight::closed;
    case Shown::nothing: return spell.trouble == Trouble::stopped ? Sight::stopped : Sight::nothing;
  }
  return Sight::unknown;
}

class Writer {
 public:
  explicit Writer(Language language) : language_(language) {}
  std::string_view in(std::string_view key) const { return text_of(key, language_); }
  void add(std::string_view html) { html_ += html; }
  template <class... Arguments>
  void add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    html_ += fmt::format(format, std::forward<Arguments>(arguments)...);
  }
  void figure(std::string_view what, const std::string& value) {
    if (!value.empty()) add("<div><dt>{}</dt><dd>{}</dd></div>\n", in(what), escaped(value));
  }
  const std::string& html() const { return html_; }
  Language language() const { return language_; }

 private:
  Language language_;
  std::string html_;
};

void write_table(const ReportedStatus& told, bool machine, Writer& page) {
  for (const auto& figure : kStatusFigures) {
    const auto& shown = figure.shown;
    const auto value = told.values.of(figure.key), beside = told.values.of(shown.beside);
    if (shown.text.empty() || shown.machine != machine || !value) continue;
    const auto format = fmt::runtime(beside ? shown.page_both : shown.page);
    page.figure(shown.text, fmt::format(format, *value / shown.page_unit, beside.value_or(0.0) / shown.page_unit));
  }
}

void write_symptoms(const Diagnosis& diagnosis, Writer& page) {
  page.add("<section aria-labelledby=\"wrong\">\n<h2 id=\"wrong\">{}</h2>\n", page.in("figure.wrong"));
  if (diagnosis.symptoms.empty()) page.add("<p>{}</p>\n", page.in("figure.nothing_wrong"));
  if (!diagnosis.symptoms.empty()) page.add("<ul class=\"symptoms\">\n");
  for (const auto& symptom : diagnosis.symptoms) {
    const auto words = symptom_words(symptom.ill, page.language());
    page.add("<li><h3>{}</h3>\n", escaped(words.what));
    if (!symptom.detail.empty())
      page.add("<p class=\"detail\"><q lang=\"en\">{}</q></p>\n", escaped(detail_text(symptom, page.language())));
    page.add("<p>{}</p>\n<code lang=\"en\">{}</code></li>\n", escaped(words.what_to_do),
             escaped(command_for(symptom.ill)));
  }
  if (!diagnosis.symptoms.empty()) page.add("</ul>\n");
  page.add("</section>\n");
}

// Where content is asked for: what it last said, and how far the next is.
std::string pull_text(const PullStatus& pull, minutes wall, const Writer& page) {
  const auto asked = pull.asked ? fmt::format("{} {}", page.in("page.answered"),
                                              wall_stamp(std::chrono::floor<minutes>(*pull.asked), wall))
                                : std::string(page.in("page.not_asked"));
  std::string text = pull.problem.empty() ? asked : fmt::format("{}; {}", pull.problem, asked);
  constexpr double kMega = 1e6;
  if (pull.bytes > 0)
    text += fmt::format("; {}: {:.1f}", page.in("page.arriving"), static_cast<double>(pull.bytes) / kMega);
  if (pull.bytes > 0 && pull.of_bytes > 0) text += fmt::format(" / {:.1f}", static_cast<double>(pull.of_bytes) / kMega);
  if (pull.bytes > 0) text += " MB";
  return text;
}

void write_content(const ReportedStatus& told, const std::optional<PullStatus>& pull, minutes wall, Writer& page) {
  page.figure("page.content", std::string(page.in(told.refused.empty() ? "page.as_configured" : "page.earlier")));
  if (told.arrived)
    page.figure("page.brought", fmt::format("{}: {}", wall_stamp(std::chrono::floor<minutes>(*told.arrived), wall),
                                            told.arrived_words));
  if (pull) page.figure("page.server", pull_text(*pull, wall, page));
}

void write_figures(const ReportedStatus& told, const std::optional<PullStatus>& pull, minutes wall, Writer& page) {
  page.add("<section aria-labelledby=\"figures\">\n<h2 id=\"figures\">{}</h2>\n<dl>\n", page.in("page.figures"));
  const auto camera = [&](const ReportedCamera& of) {
    if (!of.values.is("up"))
      return fmt::format("{}{}{}", page.in("page.fails"), of.cause.empty() ? "" : ": ", of.cause);
    std::string text(page.in("page.works"));
    const auto width = of.values["width"], height = of.values["height"];
    if (width && height) text += fmt::format(", {:.0f} × {:.0f} {}", *width, *height, of.format);
    return text;
  };
  write_table(told, false, page);
  page.figure("figure.scene", camera(told.scene_camera));
  page.figure("figure.sky", camera(told.sky_camera));
  write_table(told, true, page);
  write_content(told, pull, wall, page);
  if (told.since) page.figure("page.running", wall_stamp(std::chrono::floor<minutes>(*told.since), wall));
  page.add("</dl>\n</section>\n");
}

void write_day(const StatePage& of, Writer& page) {
  const auto now = std::chrono::floor<minutes>(of.now);
  std::vector<HistoryLine> day;
  for (const auto& line : of.history)
    if (line.utc > now - kDay && line.utc <= now) day.push_back(line);
  page.add("<section aria-labelledby=\"day\">\n<h2 id=\"day\">{}</h2>\n", page.in("page.day"));
  if (day.empty()) {
    page.add("<p>{}</p>\n</section>\n", page.in("page.no_history"));
    return;
  }
  const PlotWords words{page.in("page.plot"), page.in("page.strip"), "T", page.in("figure.aod"),
                        page.in("page.no_figures")};
  page.add("<div class=\"plot\">{}</div>\n", history_plot(day, now - kDay, now, of.wall, words));
  page.add(
      "<table>\n<thead><tr><th scope=\"col\">{}</th><th scope=\"col\">{}</th><th "
      "scope=\"col\">{}</th></tr></thead>\n<tbody>\n",
      page.in("page.from"), page.in("page.to"), page.in("figure.seen"));
  const auto spells = spells_of(day);
  const std::size_t first = spells.size() > kMostSpells ? spells.size() - kMostSpells : 0;
  for (std::size_t i = spells.size(); i-- > first;) {
    const auto& spell = spells[i];
    const auto seen = spell.told ? sight_text(sight_of_spell(spell), page.language()) : page.in("page.off");
    page.add("<tr><td>{}</td><td>{}</td><td>{}</td></tr>\n", wall_time(spell.from, of.wall).substr(11),
             wall_time(spell.to, of.wall).substr(11), escaped(seen));
  }
  page.add("</tbody>\n</table>\n</section>\n");
}

// With its seconds: what is seen in it may have changed since.
std::string wall_second(Utc utc, minutes wall) {
  const auto minute = std::chrono::floor<minutes>(utc);
  return fmt::format("{}:{:02}", wall_time(minute, wall),
                     std::chrono::floor<std::chrono::seconds>(utc - minute).count());
}

void write_screen_reply(const ScreenReply& reply, minutes wall, Writer& page) {
  const auto& picture = reply.answer.picture;
  const auto say = [&](std::string_view words, std::string_view more = {}) {
    page.add("<p role=\"status\"><strong>{}</strong>{}</p>\n", page.in(words), more);
  };
  switch (reply.outcome) {
    case ScreenOutcome::picture: {
      const int longer = std::max(picture.width(), picture.height());
      const auto side = [&](int of) { return std::max(1, of * kScreenShown_px / longer); };
      page.add("<p><img src=\"{}\" width=\"{}\" height=\"{}\" alt=\"{}\"></p>\n", bitmap_address(picture),
               side(picture.width()), side(picture.height()), page.in("page.screen_alt"));
      return say("page.screen_taken", fmt::format(" {}", wall_second(reply.answer.utc, wall)));
    }
    case ScreenOutcome::wait:
      return say("page.screen_wait", fmt::format(" {} s", reply.answer.wait.value_or(kScreenPause).count()));
    case ScreenOutcome::nothing: return say("page.screen_nothing");
    case ScreenOutcome::off: return say("page.screen_off");
    case ScreenOutcome::no_answer:
      return say("page.screen_no_answer", fmt::format(" <q lang=\"en\">{}</q>", escaped(reply.why)));
  }
}

void write_screen(const StatePage& of, Writer& page) {
  const auto& told = of.heard.status;
  const bool off = told && !told->values.is("screen_picture.allowed");
  page.add("<section aria-labelledby=\"screen\">\n<h2 id=\"screen\">{}</h2>\n", page.in("page.screen"));
  if (of.screen->reply)
    write_screen_reply(*of.screen->reply, of.wall, page);
  else if (off)
    page.add("<p>{}</p>\n", page.in("page.screen_off"));
  if (!off)
    page.add(
        "<form method=\"post\" action=\"./screen?language={}&amp;key={}\">\n<button>{}</button>\n</form>\n"
        "<p class=\"detail\">{}</p>\n",
        code_of(page.language()), escaped(of.screen->key), page.in("page.screen_take"), page.in("page.screen_note"));
  if (told && told->values["screen_picture.taken"].value_or(0.0) > 0.0)
    page.add("<p class=\"detail\">{}: {:.0f}</p>\n", page.in("page.screen_count"),
             *told->values["screen_picture.taken"]);
  page.add("</section>\n");
}

}  // namespace

Language wanted_language(std::string_view asked, std::string_view accept_language, Language fallback) {
  if (const auto language = parse_language(asked)) return *language;
  while (!accept_language.empty()) {
    const auto end = std::min(accept_language.find(','), accept_language.size());
    auto tag = accept_language.substr(0, end);
    tag.remove_prefix(std::min(tag.find_first_not_of(' '), tag.size()));
    if (const auto language = parse_language(tag.substr(0, tag.find_first_of("-; ")))) return *language;
    accept_language.remove_prefix(std::min(end + 1, accept_language.size()));
  }
  return fallback;
}

std::string state_page(const StatePage& of, Language language) {
  Writer page(language);
  const auto diagnosis = diagnose(of.heard);
  const auto state = page.in("page.state");
  page.add(
      "<!DOCTYPE html>\n<html lang=\"{}\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{}: {}</title>\n"
      "<link rel=\"stylesheet\" href=\"style.css\">\n</head>\n<body>\n",
      code_of(language), escaped(of.name), escaped(sight_text(diagnosis.sight, language)));
  page.add("<header>\n<h1>{} <span>{}</span></h1>\n</header>\n<main>\n", escaped(of.name), state);
  page.add("<section class=\"now {}\" aria-labelledby=\"seen\">\n<h2 id=\"seen\">{}</h2>\n<p class=\"sight\">{}</p>\n",
           is_well(diagnosis.sight) ? "well" : "ill", page.in("figure.seen"),
           escaped(sight_text(diagnosis.sight, language)));
  // Why, before anything else is read.
  if (!diagnosis.symptoms.empty() && !is_well(diagnosis.sight)) {
    const auto& first = diagnosis.symptoms.front();
    const bool said = diagnosis.sight == Sight::nothing && first.ill == Ill::no_display;
    page.add("<p class=\"why\">{}",
             said ? std::string() : escaped(fmt::format("{} ", symptom_words(first.ill, language).what)));
    if (!first.detail.empty()) page.add("<q lang=\"en\">{}</q>", escaped(detail_text(first, language)));
    page.add("</p>\n");
  }
  page.add("<p>{} {} <a class=\"again\" href=\"./?language={}\">{}</a></p>\n</section>\n", page.in("page.as_of"),
           wall_stamp(std::chrono::floor<minutes>(of.now), of.wall), code_of(language), page.in("page.refresh"));
  if (of.screen) write_screen(of, page);
  write_symptoms(diagnosis, page);
  if (of.heard.status) write_figures(*of.heard.status, of.pull, of.wall, page);
  write_day(of, page);
  page.add("</main>\n<footer>\n<nav aria-label=\"{}\">\n<ul>\n", page.in("page.language"));
  for (const Language other : all_languages())
    page.add("<li><a href=\"./?language={0}\" lang=\"{0}\" hreflang=\"{0}\"{1}>{2}</a></li>\n", code_of(other),
             other == language ? " aria-current=\"true\"" : "", name_of(other));
  page.add("</ul>\n</nav>\n</footer>\n</body>\n</html>\n");
  return page.html();
}

std::string_view page_style() {
  return R"(:root{color-scheme:light dark;--paper:#f2f3f5;--card:#fff;--ink:#1b1b1b;--soft:#4a4a4a;--rule:#cdd0d4;--link:#0b4a86;--code:#eceef0;--focus:#b35900}
@media (prefers-color-scheme:dark){:root{--paper:#15171a;--card:#1f2226;--ink:#ececec;--soft:#b4b8bd;--rule:#41464d;--link:#8fc3f7;--code:#2b2f35;--focus:#ffb25e}
.plot svg{filter:invert(.9) hue-rotate(180deg)}}
*{box-sizing:border-box}
body{margin:0;font:1rem/1.5 system-ui,"DejaVu Sans","Noto Sans CJK JP",VL-Gothic,sans-serif;color:var(--ink);background:var(--paper)}
header,main,footer{max-width:50rem;margin:0 auto;padding:0 1rem}
h1{font-size:1.25rem;margin:1rem 0 .75rem}
h1 span{font-weight:400;color:var(--soft)}
h2{font-size:1rem;margin:0 0 .75rem}
h3{font-size:1.05rem;margin:0 0 .25rem}
p{margin:.25rem 0}
a{color:var(--link)}
a:focus-visible{outline:3px solid var(--focus);outline-offset:2px}
section{background:var(--card);border:1px solid var(--rule);border-radius:.5rem;padding:1rem;margin:0 0 1rem}
.now{border:0;color:#fff}
.now.well{background:#1f6b3f}
.now.ill{background:#97102a}
.now h2{font-weight:400;margin:0}
.now a{color:#fff}
.now a:focus-visible{outline-color:#fff}
.sight{font-size:1.6rem;line-height:1.25;font-weight:700;margin:.25rem 0 .5rem}
.why{font-size:1.1rem;margin:0 0 .75rem}
.again{display:inline-block;margin:.25rem 0 0 .5rem;padding:.35rem .75rem;border:1px solid;border-radius:.35rem;text-decoration:none}
button{font:inherit;color:inherit;background:var(--code);border:1px solid var(--soft);border-radius:.35rem;padding:.5rem .9rem;margin:.25rem 0}
button:focus-visible{outline:3px solid var(--focus);outline-offset:2px}
.symptoms{margin:0;padding:0;list-style:none}
.symptoms li+li{border-top:1px solid var(--rule);margin-top:1rem;padding-top:1rem}
.detail{color:var(--soft)}
code{display:inline-block;background:var(--code);border-radius:.25rem;margin-top:.25rem;padding:.25rem .5rem;overflow-wrap:anywhere}
dl{margin:0;display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,13rem),1fr));gap:.75rem 1rem}
dt{color:var(--soft);font-size:.9rem}
dd{margin:0;font-weight:600;overflow-wrap:anywhere}
.plot svg{display:block;width:100%;height:auto}
@media (max-width:40rem){.plot svg{font-size:18px}}
table{border-collapse:collapse;width:100%;margin-top:1rem;font-variant-numeric:tabular-nums}
th,td{text-align:left;vertical-align:top;padding:.35rem .75rem .35rem 0;border-top:1px solid var(--rule)}
thead th{border-top:0}
td:last-child,th:last-child{width:100%}
nav ul{list-style:none;display:flex;flex-wrap:wrap;gap:.25rem;margin:0 0 2rem;padding:0}
nav a{display:block;padding:.5rem .6rem;border-radius:.35rem}
nav a[aria-current]{background:var(--ink);color:var(--paper);text-decoration:none}
)";
}

}  // namespace kasumi::report
