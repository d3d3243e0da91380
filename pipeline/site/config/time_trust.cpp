#include "pipeline/site/config/time_trust.hpp"

namespace kasumi {

SunSource TimeTrust::judge(const ClockState& state, Utc now) {
  if (state.jumps != jumps_) gained_ = false;
  jumps_ = state.jumps;
  gained_ = gained_ || state.synchronized || state.remembered;
  const bool trusted = now >= options_.earliest && (gained_ || options_.policy == ClockPolicy::trusted);
  if (trusted) return SunSource::ephemeris;
  return options_.policy == ClockPolicy::from_sky ? SunSource::image : SunSource::none;
}

}  // namespace kasumi
