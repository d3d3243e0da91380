#include "pipeline/install/camera_drift/drift.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/ranges.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/statistics.hpp"
#include "calib/mask/dome_spots.hpp"

namespace kasumi {
namespace {

constexpr double kSigmas = 5.0;  // a false alarm is worse than a late alarm
// Least deviations called drift, however small sigma is (docs/calibration.md): smaller ones shift no building by a
// visible amount.
constexpr double kMinSceneTurn_deg = 0.02, kMinSkyTurn_deg = 0.2, kMinSunOffset_deg = 0.3;
constexpr double kMinWidening = 0.3;     // of edges
constexpr double kMinVeil = 0.12;        // of the picture's mean light
constexpr double kVeiledContrast = 0.7;  // and the edges keep less than that
constexpr double kMinEvenness = 0.5;     // fogged: worst fifth of the edges keeps this share of what the best does
constexpr double kBrightestVeilReference = 0.4;  // without a darker reference a veil cannot be judged
constexpr double kMinExposure = 0.35;            // the sky's model itself is no more certain
constexpr std::size_t kFewestSuns = 3;           // a median of three is not moved by one reflection
// Suns that differ by more are reflections; the scatter has a floor, since three suns may agree by chance.
constexpr Radians kSunAgreement = from_degrees(0.4), kMinSunScatter = from_degrees(0.05);

DriftFinding undetermined(const char* camera, const char* what, std::string message) {
  return {camera, what, DriftState::undetermined, std::move(message), {}, {}, {}, {}};
}

DriftFinding judged(const char* camera, const char* what, const char* unit, double value, double sigma, double alarm,
                    std::string message) {
  return {camera, what, value > alarm ? DriftState::drifted : DriftState::steady, std::move(message), value, sigma,
          alarm,  unit};
}

// The camera's own motion, which is opposite to its picture's.
std::string turn_text(const ViewTurn& turn) {
  const auto part = [](double radians, const char* one, const char* other) {
    return fmt::format("{:.2f} {}", std::abs(to_degrees(Radians{radians})), radians >= 0.0 ? one : other);
  };
  return fmt::format("{:.3f} +- {:.3f} deg ({}, {}, {})", to_degrees(turn.angle()), to_degrees(turn.sigma()),
                     part(turn.turn.x, "down", "up"), part(turn.turn.y, "left", "right"),
                     part(turn.turn.z, "counter-clockwise", "clockwise"));
}

// The air's turbidity then and now, where both could be estimated.
struct HazeChange {
  std::optional<double> before, now;
  bool known() const { return before && now; }
  bool thicker() const { return *now > 1.5 * *before; }
};

DriftFinding judge_focus(const char* name, const std::optional<EdgeChange>& measured) {
  if (!measured) return undetermined(name, "focus", "too few clear edges");
  const EdgeChange& change = *measured;
  if (change.edges < 12 || 3 * change.edges < change.sought)
    return undetermined(name, "focus",
                        fmt::format("only {1} of {0} edges are visible: haze, darkness or a lens far out of focus",
                                    change.sought, change.edges));
  const double widening = change.spread_ratio - 1.0;
  const double alarm = std::max(kMinWidening, kSigmas * change.spread_sigma);
  const auto message = fmt::format("edges are {:.2f} +- {:.2f} times as wide as before ({:.2f} px, before {:.2f} px)",
                                   change.spread_ratio, change.spread_sigma, change.now_px, change.before_px);
  return judged(name, "focus", "percent", 100.0 * widening, 100.0 * change.spread_sigma, 100.0 * alarm,
                widening > alarm ? "out of focus: " + message : message);
}

// Haze raises the turbidity and weakens distant edges more; a fogged lens weakens all edges alike.
DriftFinding judge_lens(const char* name, const std::optional<Veil>& veil, const std::optional<EdgeChange>& change,
                        const HazeChange& haze) {
  if (!veil || !change || veil->before > kBrightestVeilReference)
    return undetermined(name, "lens", "nothing dark and near that would show a fogged lens");
  const double more = veil->now - veil->before;
  const bool pale = change->contrast_ratio < kVeiledContrast;
  auto finding = judged(name, "lens", "percent", 100.0 * more, 0.0, 100.0 * kMinVeil,
                        fmt::format("{:.0f} % of the mean light veils the darkest parts, before {:.0f} %; edges keep "
                                    "{:.0f} % of their contrast",
                                    100.0 * veil->now, 100.0 * veil->before, 100.0 * change->contrast_ratio));
  finding.sigma.reset();
  const bool alike = change->step_low > kMinEvenness * change->step_high;
  const bool fogged = finding.state == DriftState::drifted && pale && alike;
  if (fogged && haze.known() && !haze.thicker())
    finding.message = "fogged or dirty: " + finding.message;
  else if (fogged && !haze.known())
    finding =
        undetermined(name, "lens", finding.message + ": a fogged lens or hazy air, since the turbidity is unknown");
  else
    finding.state = DriftState::steady;
  if (finding.state == DriftState::steady && pale) finding.message += ": the air is hazier, the lens is clear";
  return finding;
}

// One camera's view of static things, before and now.
struct View {
  const char* name;
  const Camera& camera;
  const std::optional<ViewReference>& before;
  const std::vector<GreyImage>& now;
  double least_turn_deg;            // smallest turn called drift
  Image<std::uint8_t> usable = {};  // where static things are; empty: everywhere
};

DriftFinding judge_turn(const View& view, const std::optional<ViewTurn>& turn) {
  if (!turn)
    return undetermined(view.name, "view",
                        "nothing matches the reference: darkness, fog, snow, or the camera was turned far away");
  const double angle_deg = to_degrees(turn->angle()), sigma_deg = to_degrees(turn->sigma());
  const double alarm_deg = std::max(view.least_turn_deg, kSigmas * sigma_deg);
  return judged(view.name, "view", "deg", angle_deg, sigma_deg, alarm_deg,
                angle_deg > alarm_deg ? "the camera has turned by " + turn_text(*turn)
                                      : fmt::format("unchanged within {:.3f} +- {:.3f} deg", angle_deg, sigma_deg));
}

// Focus and lens can be judged only where the view matches the reference.
std::vector<DriftFinding> judge_view(const View& view, const HazeChange& haze) {
  if (!view.before) return {undetermined(view.name, "view", "the reference has no picture of this camera")};
  if (view.now.size() < std::size_t{kFewestCheckFrames})
    return {undetermined(view.name, "view", fmt::format("only {} pictures arrived", view.now.size()))};
  const auto still = median_of(view.now);
  const auto now = shrunk_view(still, view.camera, view.usable);
  auto before = view.before->lines;
  before.usable = view.usable;
  const auto& lens = *view.camera.lens;
  const auto turn = find_turn(lens, before, lines_of(lens, now));
  std::vector<DriftFinding> findings{judge_turn(view, turn)};
  if (!turn) return findings;
  const auto change = compare_edges(lens, view.before->edges, *turn, light_of(still, view.camera));
  findings.push_back(judge_focus(view.name, change));
  const auto veil = compare_veil(lens, view.before->darkest, now, *turn);
  findings.push_back(judge_lens(view.name, veil, change, haze));
  return findings;
}

// The shortest rotation from the sun in the picture to its ephemeris.
glm::dvec3 offset_of(const SunObservation& sun) {
  return glm::cross(sun.picture, sun.ephemeris);
}

// The largest group of observations that agree: bright clouds mistaken for the sun scatter.
std::vector<SunObservation> largest_agreeing_group(const std::vector<SunObservation>& all) {
  std::vector<SunObservation> best;
  for (const auto& one : all) {
    std::vector<SunObservation> group;
    for (const auto& other : all)
      if (glm::length(offset_of(other) - offset_of(one)) < kSunAgreement.value) group.push_back(other);
    if (group.size() > best.size()) best = std::move(group);
  }
  return best;
}

// Fits the small rotation from the suns in the pictures to their ephemeris.
DriftFinding judge_sun(const std::vector<SunObservation>& all) {
  const auto suns = largest_agreeing_group(all);
  if (suns.size() < kFewestSuns || 2 * suns.size() <= all.size())
    return undetermined(
        "sky", "sun",
        fmt::format(
            "{} pictures show a candidate for the sun, and {} of them agree: at least {} and a majority are needed",
            all.size(), suns.size(), kFewestSuns));
  // Regularised, since a rotation about the suns' own direction is not observable.
  glm::dmat3 normal{0.03 * static_cast<double>(suns.size())};
  glm::dvec3 right{0.0};
  for (const auto& sun : suns) {
    normal += glm::dmat3{1.0} - glm::outerProduct(sun.picture, sun.picture);
    right += offset_of(sun);
  }
  const auto offset = glm::inverse(normal) * right;
  std::vector<double> misfits;
  for (const auto& sun : suns)
    misfits.push_back(glm::length(sun.ephemeris - sun.picture - glm::cross(offset, sun.picture)));
  const double scatter = std::max(kMinSunScatter.value, median(std::move(misfits)));
  const double angle_deg = to_degrees(Radians{glm::length(offset)});
  const double sigma_deg =
      to_degrees(Radians{scatter / kMedianLengthOverSigma / std::sqrt(static_cast<double>(suns.size()))});
  const double alarm_deg = std::max(kMinSunOffset_deg, kSigmas * sigma_deg);
  const auto message = fmt::format("the sun is {:.2f} +- {:.2f} deg off its expected position ({} pictures)", angle_deg,
                                   sigma_deg, suns.size());
  return judged("sky", "sun", "deg", angle_deg, sigma_deg, alarm_deg,
                angle_deg > alarm_deg ? "the camera has turned, or the clock is wrong: " + message : message);
}

DriftFinding judge_dome(const DriftFrames& frames, const DriftReference& reference, const Camera& sky) {
  if (!reference.dome || frames.dome().empty()) return undetermined("sky", "dome", "no pictures of the sky to compare");
  auto suns = reference.suns;
  suns.insert(suns.end(), frames.sun_places().begin(), frames.sun_places().end());
  const auto& looks = frames.dome();
  const auto state = find_spots(looks, *reference.dome, open_sky(sky, looks[0].width(), looks[0].height(), suns));
  if (!(state.looked_at > 0.0)) return undetermined("sky", "dome", "too little open sky is visible");
  double area = 0.0;
  for (const auto& spot : state.spots) area += spot.area;
  if (state.spots.empty())
    return judged("sky", "dome", "percent", 0.0, 0.0, 100.0 * state.least_dimming,
                  fmt::format("clean: no spot dimmer by {:.0f} %", 100.0 * state.least_dimming));
  const double dimming = state.spots.front().dimming;
  return judged("sky", "dome", "percent", 100.0 * dimming, 0.0, 100.0 * state.least_dimming,
                fmt::format("dirty: {} spot{} on {:.1f} % of the open sky, the darkest takes {:.0f} % of the light",
                            state.spots.size(), state.spots.size() == 1 ? "" : "s", 100.0 * area, 100.0 * dimming));
}

DriftFinding judge_exposure(const DriftFrames& frames, const DriftReference& reference) {
  if (!reference.level) return undetermined("sky", "exposure", "the reference has no clear sky of known exposure");
  auto levels = frames.levels();
  if (levels.size() < std::size_t{kFewestCheckFrames})
    return undetermined("sky", "exposure", "no clear sky of known exposure");
  std::sort(levels.begin(), levels.end());
  const double change = std::exp(levels[levels.size() / 2] - *reference.level) - 1.0;
  const double sigma = 0.5 * (levels[levels.size() * 3 / 4] - levels[levels.size() / 4]);
  return judged("sky", "exposure", "percent", 100.0 * std::abs(change), 100.0 * sigma,
                100.0 * std::max(kMinExposure, kSigmas * sigma),
                fmt::format("the clear sky, relative to the exposure, is {:.0f} +- {:.0f} % {} than before",
                            100.0 * std::abs(change), 100.0 * sigma, change < 0.0 ? "darker" : "brighter"));
}

}  // namespace

std::string_view name_of(DriftState state) {
  switch (state) {
    case DriftState::steady: return "steady";
    case DriftState::drifted: return "drifted";
    case DriftState::undetermined: return "untold";
  }
  return "";
}

bool DriftReport::steady() const {
  return std::none_of(findings.begin(), findings.end(),
                      [](const DriftFinding& finding) { return finding.state == DriftState::drifted; });
}

DriftReport find_drift(const DriftFrames& frames, const DriftReference& reference, const Installation& installation,
                       Utc now) {
  const Camera &scene = installation.scene, &sky = installation.sky;
  const HazeChange haze{reference.turbidity, median_if_enough(frames.turbidities())};
  DriftReport report{now, reference.taken, {}};
  auto& findings = report.findings;
  for (const View& view :
       {View{"scene", scene, reference.scene, frames.scene(), kMinSceneTurn_deg},
        View{"sky", sky, reference.sky, frames.sky(), kMinSkyTurn_deg, still_part_of_sky(sky, shrink_factor(sky))}})
    std::ranges::move(judge_view(view, haze), std::back_inserter(findings));
  findings.push_back(judge_sun(frames.suns()));
  findings.push_back(judge_dome(frames, reference, sky));
  findings.push_back(judge_exposure(frames, reference));
  return report;
}

std::string drift_summary(const DriftReport& report) {
  std::vector<std::string> parts;
  for (const auto& finding : report.findings)
    if (finding.state == DriftState::drifted)
      parts.push_back(fmt::format("{} camera, {}: {}", finding.camera, finding.what, finding.message));
  if (!parts.empty()) return fmt::format("{}", fmt::join(parts, "; "));
  const auto undetermined =
      std::count_if(report.findings.begin(), report.findings.end(),
                    [](const DriftFinding& finding) { return finding.state == DriftState::undetermined; });
  return undetermined == 0
             ? "no drift found"
             : fmt::format("no drift found, {} of {} checks inconclusive", undetermined, report.findings.size());
}

std::string drift_text(const DriftReport& report) {
  std::string text;
  for (const auto& finding : report.findings) {
    const char* mark = finding.state == DriftState::drifted  ? " DRIFT "
                       : finding.state == DriftState::steady ? "  ok   "
                                                             : "  ?    ";
    text += fmt::format("{}{:<16} {}\n", mark, finding.camera + "." + finding.what, finding.message);
  }
  return text;
}

}  // namespace kasumi
