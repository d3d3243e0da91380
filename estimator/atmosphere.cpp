#include "estimator/atmosphere.hpp"

namespace kasumi {

std::string_view name_of(SkyCondition condition) {
  switch (condition) {
    case SkyCondition::clear: return "clear";
    case SkyCondition::partly_cloudy: return "partly cloudy";
    case SkyCondition::overcast: return "overcast";
    case SkyCondition::sun_too_low: return "sun too low";
    case SkyCondition::night: return "night";
    case SkyCondition::covered_lens: return "covered lens";
    case SkyCondition::unknown: return "unknown";
  }
  return "unknown";
}

}  // namespace kasumi
