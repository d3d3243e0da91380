#include "tests/paper/report/section.hpp"
namespace kasumi::paper {
Section photographs_section(const ReportOptions&) {
  return {"photographs", "x"};
}
}  // namespace kasumi::paper
