// Included before all else where things are logged. fmt's formatting is in its library; without this line each file compiles it
// again, which takes the compiler two seconds and the address sanitizer's six.
#pragma once

#include <fmt/format.h>

#if FMT_VERSION / 10000 == 9  // declared as in Debian 12; another version compiles its own
extern template void fmt::detail::vformat_to<char>(buffer<char>&, basic_string_view<char>,
                                                   basic_format_args<buffer_context<char>>, locale_ref);
#endif
