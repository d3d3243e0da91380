// What a test needs to go on: a result that holds something, a program that ended as it should. Otherwise the test ends,
// and says where and why. And what a test expects of faults.
#pragma once

#include <source_location>
#include <stdexcept>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <gmock/gmock.h>

namespace kasumi {

[[noreturn]] inline void end_test(const std::source_location& at, std::string_view why) {
  throw std::runtime_error(fmt::format("{}:{}: {}", at.file_name(), at.line(), why));  // GoogleTest reports it
}

// The same Result, optional or pointer.
template <class Held>
Held must(Held held, std::source_location at = std::source_location::current()) {
  if (held) return held;
  if constexpr (requires { held.error().message; }) end_test(at, held.error().message);
  end_test(at, "there is nothing");
}

// The same outcome of a program.
template <class Outcome>
Outcome ended(int code, Outcome outcome, std::source_location at = std::source_location::current()) {
  if (outcome.code != code) end_test(at, fmt::format("ended with {}, not {}:\n{}", outcome.code, code, outcome.err));
  return outcome;
}

// EXPECT_THAT(read(file), FailsWith(HasSubstr("not there")))
MATCHER_P(FailsWith, message, "") {
  if (arg) return false;
  return testing::ExplainMatchResult(message, arg.error().message, result_listener);
}
MATCHER_P2(FailsAs, kind, message, "") {
  if (arg) return false;
  *result_listener << "of kind " << name_of(arg.error().kind) << ": ";
  return arg.error().kind == kind && testing::ExplainMatchResult(message, arg.error().message, result_listener);
}

}  // namespace kasumi
