// Included before all else where things are logged. fmt's formatting is in its library: without the declaration below each
// file compiles it again, which takes two seconds, and six with the address sanitizer.
#pragma once

#include <fmt/format.h>

#if FMT_VERSION / 10000 == 9  // declared as in Debian 12; another version compiles its own
extern template void fmt::detail::vformat_to<char>(buffer<char>&, basic_string_view<char>,
                                                   basic_format_args<buffer_context<char>>, locale_ref);
#endif
