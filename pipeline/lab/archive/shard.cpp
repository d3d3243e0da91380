#include "pipeline/lab/archive/shard.hpp"

#include <array>
#include <charconv>
#include <optional>
#include <string_view>

namespace kasumi {
namespace {

std::optional<long> whole_number(std::string_view text) {
  long number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

// Names of an engine's variables; null: it has none.
struct ArrayVariables {
  const char *task, *count, *first, *last, *step;
};
constexpr std::array kEngines{
    ArrayVariables{"SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", "SLURM_ARRAY_TASK_MIN", nullptr,
                   "SLURM_ARRAY_TASK_STEP"},
    ArrayVariables{"JOB_COMPLETION_INDEX", "JOB_COMPLETIONS", nullptr, nullptr, nullptr},
    ArrayVariables{"SGE_TASK_ID", nullptr, "SGE_TASK_FIRST", "SGE_TASK_LAST", "SGE_TASK_STEPSIZE"},
};

class Variables {
 public:
  explicit Variables(const Environment& environment) : environment_(environment) {}
  // Grid Engine sets "undefined" outside of arrays.
  bool has(const char* name) const {
    const char* text = name ? environment_(name) : nullptr;
    return text && *text != '\0' && std::string_view(text) != "undefined";
  }
  long number(const char* name, long otherwise, long least) {
    if (!has(name)) return otherwise;
    const auto number = whole_number(environment_(name));
    if (!number || *number < least)
      problems_.add("{}={}: expected a number from {} on", name, environment_(name), least);
    return number.value_or(otherwise);
  }
  void need(const char* name, const char* beside) {
    if (name && !has(name)) problems_.add("{}: is set without {}, expected both, or --shard I/N", beside, name);
  }
  const Problems& problems() const { return problems_; }

 private:
  const Environment& environment_;
  Problems problems_;
};

Result<Shard> shard_by(const ArrayVariables& names, Variables& variables) {
  variables.need(names.count, names.task);
  variables.need(names.first, names.task);
  variables.need(names.last, names.task);
  const long task = variables.number(names.task, 0, 0), first = variables.number(names.first, 0, 0);
  const long step = variables.number(names.step, 1, 1), last = variables.number(names.last, first, 0);
  if (!variables.problems().empty()) return fail(variables.problems().fault());
  const long count = names.count ? variables.number(names.count, 1, 1) : (last - first) / step + 1;
  if (!variables.problems().empty()) return fail(variables.problems().fault());
  const long index = (task - first) / step;
  if (task < first || (task - first) % step != 0 || index >= count)
    return fail(FaultKind::bad_input, "{}={}: expected one of {} tasks from {} on{}, without gaps, or --shard I/N",
                names.task, task, count, first, step > 1 ? fmt::format(" in steps of {}", step) : "");
  return Shard{static_cast<std::size_t>(index), static_cast<std::size_t>(count), names.task};
}

}  // namespace

std::size_t Shard::first(std::size_t size) const {
  // size * index may overflow
  return size / count * index + size % count * index / count;
}

std::size_t Shard::size(std::size_t size) const {
  return Shard{index + 1, count, {}}.first(size) - first(size);
}

Result<Shard> shard_of(const std::string& given, const Environment& environment) {
  if (!given.empty()) {
    const auto slash = given.find('/');
    const auto text = std::string_view(given);
    const auto index = whole_number(text.substr(0, slash));
    const auto count = whole_number(slash == std::string::npos ? "" : text.substr(slash + 1));
    if (index.value_or(0) < 1 || index.value_or(0) > count.value_or(0))
      return fail(FaultKind::bad_input, "--shard {}: expected I/N like 3/40, I from 1 to N", given);
    return Shard{static_cast<std::size_t>(index.value_or(1) - 1), static_cast<std::size_t>(count.value_or(1)),
                 "--shard"};
  }
  Variables variables(environment);
  for (const auto& names : kEngines)
    if (variables.has(names.task)) return shard_by(names, variables);
  return Shard{};
}

}  // namespace kasumi
