#include "estimator/fusion/air_observation.hpp"

namespace kasumi {

std::string_view name_of(AirObserver observer) {
  switch (observer) {
    case AirObserver::sky: return "sky";
    case AirObserver::landmarks: return "landmarks";
    case AirObserver::horizon: return "horizon";
    case AirObserver::remembered: return "remembered";
    case AirObserver::given: return "given";
    case AirObserver::supposed: break;
  }
  return "supposed";
}

}  // namespace kasumi
