#include "gles/air/dome_renderer.hpp"

#include <array>
#include <cmath>
#include <map>

#include <glm/geometric.hpp>

#include "base/sky/sun_disc.hpp"
#include "gles/air/dome_mesh.hpp"
#include "gles/gl/gl.hpp"
#include "gles/gl/grid_mesh.hpp"
#include "gles/gl/patterns.hpp"
#include "gles/gl/program.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {

// Named, because DomeRenderer::State has members of it.
enum class DomePart { sky, sun, land };

namespace {

// Half a step of 8 bits.
constexpr double kTolerance = 0.5 / 255.0;

Defines defines_of(PanoramaProjection projection, SkyKind kind, DomeDetail detail) {
  Defines defines;
  if (projection == PanoramaProjection::fisheye) defines.insert("FISHEYE");
  if (projection == PanoramaProjection::equirectangular) defines.insert("EQUIRECTANGULAR");
  if (kind == SkyKind::preetham1999) defines.insert("PREETHAM");
  if (kind == SkyKind::hoffman_preetham2002) defines.insert("HOFFMAN_PREETHAM");
  if (kind == SkyKind::nielsen2003) defines.insert("NIELSEN");
  if (detail == DomeDetail::per_fragment) defines.insert("PER_FRAGMENT");
  return defines;
}

Result<Program> build(DomePart part, const Defines& defines) {
  switch (part) {
    case DomePart::sky: return Program::build(defines, "dome.vert", "dome.frag");
    case DomePart::sun: return Program::build(defines, "dome_sun.vert", "dome.frag");
    case DomePart::land: return Program::build(defines, "dome_land.vert", "dome.frag");
  }
  return fail(FaultKind::device, "no such program");
}

std::vector<glm::dvec3> doubles(std::span<const glm::vec3> values) {
  return {values.begin(), values.end()};
}

void set_sky(const Program& program, const std::string& name, const DomeFunction& sky) {
  program.set(name + ".horizon_sine", double{sky.horizon_sine});
  program.set(name + ".steepness", double{sky.steepness});
  program.set(name + ".lobes", glm::dvec3(sky.lobes));
  program.set(name + ".coefficients", doubles(sky.coefficients));
}

void set_air(const Program& program, const std::string& name, const AirCoefficients& air) {
  program.set(name + ".weight", doubles(air.weight));
  program.set(name + ".molecules_per_m", doubles(air.molecules_per_m));
  program.set(name + ".aerosol_per_m", doubles(air.aerosol_per_m));
  program.set(name + ".ozone", doubles(air.ozone));
}

void set_older(const Program& program, const std::string& name, const sky_text::OlderAir& air) {
  program.set(name + ".rayleigh_per_m", air.rayleigh_per_m);
  program.set(name + ".mie_per_m", air.mie_per_m);
  program.set(name + ".sunlight", air.sunlight);
  program.set(name + ".asymmetry", air.asymmetry);
  program.set(name + ".altitude_m", air.altitude_m);
}

void set_perez(const Program& program, const sky_text::PerezSky& perez) {
  program.set("perez.zenith", perez.zenith);
  program.set("perez.a", perez.a);
  program.set("perez.b", perez.b);
  program.set("perez.c", perez.c);
  program.set("perez.d", perez.d);
  program.set("perez.e", perez.e);
}

Result<GridMesh> corners_of(const std::vector<double>& columns, const std::vector<double>& rows) {
  std::vector<float> places;
  for (const double y : rows)
    for (const double x : columns) {
      places.push_back(static_cast<float>(x));
      places.push_back(static_cast<float>(y));
    }
  return GridMesh::create(static_cast<int>(columns.size()), static_cast<int>(rows.size()), 2, places,
                          {{kPosition, 2, 0}});
}

// Rings from the disc's middle to beyond its edge.
Result<GridMesh> rings_of_sun() {
  constexpr int kSectors = 49;
  constexpr std::array kRings{0.0, 0.5, 0.75, 0.9, 0.97, 1.0, 2.0};
  std::vector<float> places;
  for (const double ring : kRings)
    for (int i = 0; i < kSectors; ++i) {
      places.push_back(static_cast<float>(ring));
      places.push_back(static_cast<float>(2.0 * kPi * i / (kSectors - 1)));
    }
  return GridMesh::create(kSectors, static_cast<int>(kRings.size()), 2, places, {{kPosition, 2, 0}});
}

}  // namespace

struct DomeRenderer::State {
  GlTexture dither;
  std::map<std::pair<DomePart, Defines>, Program> programs;
  PanoramaView view;
  DomeScene scene;
  DomeMesh lines;
  std::optional<GridMesh> mesh, whole, sun, land;

  Result<const Program*> find(DomePart part, DomeDetail detail) {
    const Defines defines = defines_of(view.projection, scene.kind, detail);
    const auto known = programs.find({part, defines});
    if (known != programs.end()) return &known->second;
    auto made = build(part, defines);
    if (!made) return fail(made.error());
    return &programs.emplace(std::pair(part, defines), std::move(*made)).first->second;
  }

  // Sets the uniforms that all parts share.
  void begin(const Program& program, const DrawTarget& target) const {
    program.use();
    program.set("dither_pattern", kDitherUnit);
    program.set("camera_to_world", view.camera_to_world);
    program.set("focal_px", view.focal_px);
    program.set("place_to_clip", glm::dvec2(2.0 / view.width, (target.top_row_first ? 2.0 : -2.0) / view.height));
    program.set("circle_px", 0.5 * kPi * view.focal_px);
    program.set("exposure", scene.exposure);
    program.set("sun", scene.sun);
    program.set("sun_luminance", scene.sun_luminance);
    set_perez(program, scene.perez);
    set_older(program, "older", scene.older);
    set_sky(program, "sky", scene.sky);
  }

  Result<> draw_sky(const DrawTarget& target, DomeDetail detail) {
    const bool exact = detail == DomeDetail::per_fragment;
    const auto program = find(DomePart::sky, detail);
    if (!program) return fail(program.error());
    begin(**program, target);
    (exact ? whole : mesh)->draw();
    return {};
  }

  Result<> draw_sun(const DrawTarget& target, double pixel_rad) {
    const auto program = find(DomePart::sun, DomeDetail::per_vertex);
    if (!program) return fail(program.error());
    begin(**program, target);
    (*program)->set("sun_radius", double{kDomeSunRadius_rad});
    (*program)->set("blur", 0.5 * pixel_rad / double{kDomeSunRadius_rad});
    sun->draw();
    return {};
  }

  Result<> draw_land(const DrawTarget& target) {
    const auto program = find(DomePart::land, DomeDetail::per_vertex);
    if (!program) return fail(program.error());
    const Program& p = **program;
    begin(p, target);
    set_sky(p, "between.lower", scene.lower);
    set_sky(p, "between.higher", scene.higher);
    set_air(p, "between.air", scene.air);
    const sky_text::AirBetween between = air_between(scene);
    p.set("between.altitude_m", between.altitude_m);
    p.set("between.sun_lower", between.sun_lower);
    p.set("between.sun_higher", between.sun_higher);
    p.set("between.haze.albedo", between.haze.albedo);
    p.set("between.haze.asymmetry", between.haze.asymmetry);
    p.set("between.haze.height", between.haze.height);
    p.set("between.departures", scene.departures);
    p.set("between.departures_sun", scene.departures_sun);
    p.set("between.below", scene.below);
    p.set("between.below_steep", scene.below_steep);
    set_older(p, "older_air", scene.older);
    p.set("observer_m", scene.altitude_m);
    p.set("air_share", scene.aerial_perspective ? 1.0 : 0.0);
    p.set("sky_lower", scene.land_lower.sky);
    p.set("sky_higher", scene.land_higher.sky);
    land->draw();
    return {};
  }
};

DomeRenderer::DomeRenderer(std::unique_ptr<State> state) : state_(std::move(state)) {}
DomeRenderer::DomeRenderer(DomeRenderer&&) noexcept = default;
DomeRenderer& DomeRenderer::operator=(DomeRenderer&&) noexcept = default;
DomeRenderer::~DomeRenderer() = default;

Result<DomeRenderer> DomeRenderer::create(GlContext& context) {
  if (auto current = context.make_current(); !current) return fail(current.error());
  auto state = std::make_unique<State>();
  state->dither = make_dither_pattern();
  auto sun = rings_of_sun();
  if (!sun) return fail(sun.error());
  state->sun = std::move(*sun);
  return DomeRenderer(std::move(state));
}

Result<> DomeRenderer::set(const PanoramaView& view, const DomeScene& scene) {
  if (view.width < 1 || view.height < 1 || !(view.focal_px > 0.0) || !std::isfinite(view.focal_px))
    return fail(FaultKind::bad_input, "a sky of {} x {} pixels with a focal length of {} px: expected all above 0",
                view.width, view.height, view.focal_px);
  State& s = *state_;
  s.view = view;
  s.scene = scene;
  s.lines = make_dome_mesh(view, DomePainter(scene), scene.sun, kTolerance);
  auto mesh = corners_of(s.lines.columns, s.lines.rows);
  if (!mesh) return fail(mesh.error());
  s.mesh = std::move(*mesh);
  auto whole =
      corners_of({s.lines.columns.front(), s.lines.columns.back()}, {s.lines.rows.front(), s.lines.rows.back()});
  if (!whole) return fail(whole.error());
  s.whole = std::move(*whole);
  return {};
}

Result<> DomeRenderer::set_land(const DomeLand& land) {
  state_->land.reset();
  if (land.empty()) return {};
  constexpr int kFloats = 10;
  std::vector<float> values;
  values.reserve(land.vertices.size() * kFloats);
  for (const LandVertex& v : land.vertices)
    for (const float value : {v.position.x, v.position.y, v.position.z, v.normal.x, v.normal.y, v.normal.z, v.albedo.x,
                              v.albedo.y, v.albedo.z, v.altitude_m})
      values.push_back(value);
  auto mesh = GridMesh::create(land.columns, land.rings, kFloats, values,
                               {{kPosition, 3, 0}, {kNormal, 3, 3}, {kColour, 4, 6}});
  if (!mesh) return fail(mesh.error());
  state_->land = std::move(*mesh);
  return {};
}

Result<> DomeRenderer::draw(const DrawTarget& target, DomeDetail detail) {
  State& s = *state_;
  if (!s.mesh) return fail(FaultKind::bad_input, "no sky was set to draw");
  const Letterbox box = letterbox(target, s.view.width, s.view.height);
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  if (box.width != target.width || box.height != target.height) {
    glViewport(0, 0, target.width, target.height);
    glClearColor(0.0f, 0.0f, 0.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
  }
  glViewport(box.x, box.y, box.width, box.height);
  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
  glActiveTexture(GL_TEXTURE0 + kDitherUnit);
  glBindTexture(GL_TEXTURE_2D, s.dither.name());
  if (auto drawn = s.draw_sky(target, detail); !drawn) return drawn;
  if (detail == DomeDetail::per_vertex && s.scene.sun_luminance != glm::dvec3(0.0))
    if (auto drawn = s.draw_sun(target, s.view.width / (s.view.focal_px * box.width)); !drawn) return drawn;
  if (detail == DomeDetail::per_vertex && s.land && s.scene.kind != SkyKind::preetham1999)
    if (auto drawn = s.draw_land(target); !drawn) return drawn;
  return check_gl("drawing the sky");
}

DomeRenderer::Size DomeRenderer::mesh_size() const {
  return {static_cast<int>(state_->lines.columns.size()), static_cast<int>(state_->lines.rows.size())};
}

}  // namespace kasumi
