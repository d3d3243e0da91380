#include "pipeline/installation.hpp"

namespace kasumi {

namespace {

Surroundings read_surroundings(const ConfigTable& table) {
  const Surroundings usual;
  return {table.number("ground_albedo", {0.0, 1.0}, usual.ground_albedo),
          table.number("cloud_base_m", {50.0, 15e3}, usual.cloud_base_m)};
}

}  // namespace

Installation read_installation(const ConfigTable& root) {
  Installation installation;
  installation.site = read_site(root.table("site"));
  installation.surroundings = read_surroundings(root.table("site"));
  installation.sky = read_camera(root.table("sky"), "sky");
  installation.scene = read_camera(root.table("scene"), "scene");
  if (installation.scene.lens && !pinhole_model(*installation.scene.lens))
    root.table("scene").table("lens").problem(
        "model", "\"pinhole\": the picture is drawn through a pinhole (with Brown's distortion)");
  installation.object = read_placement(root.table("object"), installation.site);
  return installation;
}

}  // namespace kasumi
