#include "pipeline/installation.hpp"

namespace kasumi {

Installation read_installation(const ConfigTable& root) {
  Installation installation;
  installation.site = read_site(root.table("site"));
  installation.sky = read_camera(root.table("sky"), "sky");
  installation.scene = read_camera(root.table("scene"), "scene");
  if (installation.scene.lens && !pinhole_model(*installation.scene.lens))
    root.table("scene").table("lens").problem(
        "model", "\"pinhole\": the picture is drawn through a pinhole (with Brown's distortion)");
  installation.object = read_placement(root.table("object"), installation.site);
  return installation;
}

}  // namespace kasumi
