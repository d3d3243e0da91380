// A page in a real browser, by axe-core's rules for WCAG 2.2 AA.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "tests/places.hpp"

namespace kasumi {

inline std::filesystem::path axe_core() {
  return source_folder() / "build/browser/node_modules/axe-core/axe.min.js";
}

// Chromium without a screen, looking at a file of this folder.
inline std::string browser(const std::filesystem::path& folder, const std::string& how,
                           const std::string& page_and_output) {
  return fmt::format(
      "timeout 60 chromium --headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking "
      "--disable-component-update --disable-sync --hide-scrollbars --allow-file-access-from-files "
      "--user-data-dir={0}/profile {1} file://{0}/{2} 2> {0}/browser.log",
      folder.string(), how, fmt::format(fmt::runtime(page_and_output), folder.string()));
}

// At a telephone's width: `passes`, by how much the page is too `wide`, and its `violations`. Null: the browser failed.
inline nlohmann::json seen_by_axe(const std::filesystem::path& folder, std::string html) {
  const auto end = html.find("</body>");
  EXPECT_NE(end, std::string::npos);
  html.insert(
      end,
      fmt::format(
          "<script src=\"file://{}\"></script><script>axe.run(document, {{runOnly: ['wcag2a', 'wcag2aa', 'wcag21aa', "
          "'wcag22aa', "
          "'best-practice']}}).then(r => {{ document.documentElement.innerHTML = '<pre>RESULT' + "
          "JSON.stringify({{passes: r.passes.length, "
          "wide: document.documentElement.scrollWidth - innerWidth, violations: r.violations.map(v => v.id + ': ' + "
          "v.nodes.map(n => n.target).join(' '))}}) + 'END</pre>'; }});</script>",
          axe_core().string()));
  EXPECT_TRUE(write_text_file(folder / "page.html", html));
  const auto command =
      browser(folder, "--window-size=500,900 --virtual-time-budget=10000 --dump-dom", "page.html > {0}/dom.html");
  EXPECT_EQ(std::system(command.c_str()), 0) << read_text_file(folder / "browser.log").value_or("");
  const auto dom = read_text_file(folder / "dom.html").value_or("");
  const auto from = dom.find("RESULT"), to = dom.find("END</pre>");
  EXPECT_NE(from, std::string::npos) << dom.substr(0, 400);
  return from == std::string::npos ? nlohmann::json() : parse_json(dom.substr(from + 6, to - from - 6));
}

}  // namespace kasumi
