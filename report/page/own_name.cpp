#include "report/page/own_name.hpp"

#include <algorithm>

namespace kasumi::report {

bool is_own_name(std::string host, const std::vector<std::string>& names) {
  if (host.starts_with('[')) return true;
  host = host.substr(0, host.find(':'));
  const bool number = !host.empty() && host.find_first_not_of("0123456789.") == std::string::npos;
  return number || host == "localhost" || std::ranges::find(names, host) != names.end();
}

}  // namespace kasumi::report
