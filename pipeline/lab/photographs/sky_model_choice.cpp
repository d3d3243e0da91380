#include "pipeline/lab/photographs/sky_model_choice.hpp"

#include <memory>
#include <optional>

#include "estimator/sky/hosek.hpp"

namespace kasumi {
namespace {

constexpr std::string_view kHosek = "hosek:";

std::shared_ptr<const HosekSky> read_hosek(const std::string& file, Problems& problems) {
  auto read = HosekSky::read_file(file);
  if (read) return std::make_shared<const HosekSky>(std::move(*read));
  problems.add("--sky-model hosek: {}", read.error().message);
  return nullptr;
}

}  // namespace

ModelToFit model_to_fit(const std::string& text, double altitude_m, const GivenAir& given, Problems& problems) {
  ModelToFit sky;
  sky.altitude_m = altitude_m;
  const auto hosek = text.find(kHosek);
  const std::string name = text.substr(0, hosek);
  if (hosek != std::string::npos) sky.hosek = read_hosek(text.substr(hosek + kHosek.size()), problems);

  if (name == "auto+" || (hosek == std::string::npos && (name.empty() || name == "auto" || name == "automatic"))) {
    sky.every_model = true;
    sky.known = given;
    sky.aerosol = given.to_be_found();
    sky.model = sky.aerosol ? DaylightModel::dome : DaylightModel::preetham;
    return sky;
  }
  if (hosek == std::string::npos && name == "dome") {
    sky.model = DaylightModel::dome;
    sky.aerosol = given.to_be_found();
    return sky;
  }
  if (hosek != std::string::npos) sky.model = DaylightModel::dome;  // the nearest to Hosek's where one must be drawn
  if (!(hosek == std::string::npos ? name == "preetham" : name.empty()))
    problems.add("--sky-model {}: expected auto, preetham, dome, hosek:FILE or auto+hosek:FILE", text);
  else if (given.any())
    problems.add(
        "--aerosol, --angstrom: only the dome's sky knows an aerosol, expected --sky-model auto or --sky-model dome");
  return sky;
}

std::string_view followed_model(const ModelToFit& sky) {
  return sky.hosek && !sky.every_model ? "hosek" : name_of(sky.model);
}

}  // namespace kasumi
