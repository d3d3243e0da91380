#include "tests/paper/report/section.hpp"
namespace kasumi::paper {
Section classic_section(const ReportOptions&) {
  return {"classic", "x"};
}
}  // namespace kasumi::paper
