#include "pipeline/lab/bench/recorded_run.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"

namespace kasumi {
namespace {

using Json = nlohmann::ordered_json;

// A row's name without the indentation of those that explain the row above.
std::string plain_name(const BenchRow& row) {
  return row.name.substr(std::min(row.name.find_first_not_of(' '), row.name.size()));
}

const BenchRow* find(const std::vector<BenchRow>& rows, const std::string& name) {
  const auto found = std::ranges::find(rows, name, plain_name);
  return found == rows.end() ? nullptr : &*found;
}

double cost_growth(double before, double now, bool less_is_better) {
  return less_is_better ? now / before : before / now;
}

bool is_time(const BenchRow& row) {
  return row.unit == "ms" || row.unit.ends_with("/s") || row.unit == "s";
}

void read_row(const Json& json, std::size_t number, const std::string& file, RecordedRun& run, Problems& problems) {
  const auto wrong = [&](const char* key, const char* expected) {
    problems.add("{}: row {}: {}: expected {}", file, number, key, expected);
  };
  if (!json.is_object()) return problems.add("{}: row {}: expected an object", file, number);
  BenchRow row;
  const auto text = [&](const char* key, std::string& to) {
    if (const auto at = json.find(key); at != json.end() && at->is_string())
      to = at->get<std::string>();
    else
      wrong(key, "text");
  };
  text("name", row.name);
  text("unit", row.unit);
  if (const auto at = json.find("value"); at != json.end() && at->is_number())
    row.value = at->get<double>();
  else
    wrong("value", "a number");
  if (const auto at = json.find("goal"); at != json.end() && at->is_number())
    row.goal = at->get<double>();
  else if (at != json.end() && !at->is_null())
    wrong("goal", "a number or null");
  if (const auto at = json.find("less_is_better"); at != json.end() && at->is_boolean())
    row.less_is_better = at->get<bool>();
  else
    wrong("less_is_better", "true or false");
  if (find(run.rows, plain_name(row))) wrong("name", "one that no row before has");
  run.rows.push_back(std::move(row));
}

}  // namespace

double SlowerRow::growth() const {
  return cost_growth(before, now, less_is_better);
}

std::string processor_of(const std::string& cpuinfo) {
  int count = 0;
  std::map<std::string, std::string, std::less<>> first;
  std::istringstream lines(cpuinfo);
  for (std::string line; std::getline(lines, line);) {
    const auto colon = line.find(": ");
    if (colon == std::string::npos) continue;
    const std::string key = line.substr(0, line.find_last_not_of(" \t", colon - 1) + 1);
    count += key == "processor";
    first.try_emplace(key, line.substr(colon + 2));
  }
  std::string said = fmt::format("{} x", count);
  for (const char* key : {"model name", "cpu family", "model", "stepping", "CPU implementer", "CPU part"})
    if (const auto at = first.find(key); at != first.end())
      said += at->first == "model name" ? fmt::format(" {},", at->second) : fmt::format(" {} {},", key, at->second);
  if (said.ends_with(',')) said.pop_back();
  return said;
}

std::string json_of(const RecordedRun& run) {
  Json rows = Json::array();
  for (const BenchRow& row : run.rows)
    rows.push_back({{"name", plain_name(row)},
                    {"value", row.value},
                    {"unit", row.unit},
                    {"goal", row.goal ? Json(*row.goal) : Json(nullptr)},
                    {"less_is_better", row.less_is_better}});
  const Json json = {{"kasumi", run.version}, {"processor", run.processor}, {"renderer", run.renderer}, {"rows", rows}};
  return text_of_json(json, 2) + "\n";
}

Result<RecordedRun> read_recorded_run(const std::filesystem::path& file) {
  const auto text = read_text_file(file);
  if (!text) return fail(text.error());
  const auto json = parse_ordered_json(*text);
  const auto rows = json.is_object() ? json.find("rows") : json.end();
  if (!json.is_object() || rows == json.end() || !rows->is_array())
    return fail(FaultKind::bad_input, "{}: expected what `kasumi bench --json` writes, an object with \"rows\"",
                file.string());
  RecordedRun run;
  Problems problems;
  for (const auto& [key, to] :
       {std::pair{"kasumi", &run.version}, {"processor", &run.processor}, {"renderer", &run.renderer}}) {
    if (const auto at = json.find(key); at != json.end() && at->is_string())
      *to = at->get<std::string>();
    else
      problems.add("{}: {}: expected text", file.string(), key);
  }
  for (std::size_t i = 0; i < rows->size(); ++i) read_row((*rows)[i], i + 1, file.string(), run, problems);
  if (!problems.empty()) return fail(problems.fault());
  return run;
}

RunComparison compare_runs(const RecordedRun& before, const RecordedRun& now) {
  RunComparison result;
  result.same_machine = before.processor == now.processor && before.renderer == now.renderer;
  for (const BenchRow& row : now.rows) {
    const std::string name = plain_name(row);
    const BenchRow* then = find(before.rows, name);
    if (!then) {
      result.not_found.push_back(name);
      continue;
    }
    if (is_time(row) && !result.same_machine) continue;
    const SlowerRow slower{name, row.unit, then->value, row.value, row.less_is_better};
    if (!(slower.growth() <= kToldGrowth)) result.slower.push_back(slower);
  }
  for (const BenchRow& row : before.rows)
    if (!find(now.rows, plain_name(row))) result.gone.push_back(plain_name(row));
  return result;
}

void keep_better(std::vector<BenchRow>& rows, const std::vector<BenchRow>& again) {
  for (BenchRow& row : rows)
    if (const BenchRow* second = find(again, plain_name(row)))
      row.value = row.less_is_better ? std::min(row.value, second->value) : std::max(row.value, second->value);
}

}  // namespace kasumi
