// The room's texture units. A unit with two uses has two names, with the reason why they do not collide.
#pragma once

namespace kasumi {

constexpr int kPromisedUnits = 8;  // by GLES 2: units 0 to 7

enum TextureUnit : int {
  kPlaneUnit = 0,  // the camera's planes: 0, 1, 2
  kLayerUnit = 3,
  kForegroundUnit = 4,
  kResponseUnit = 5,
  kDitherUnit = 6,
  kSurfaceUnit = 7,           // a material's colour
  kNoiseUnit = kSurfaceUnit,  // shared: noise is used with the camera's picture, where no surface is drawn

  kGroundSunlightUnit = kPlaneUnit,  // shared: used for the layer, which is drawn without the camera's picture
  kFootShadeUnit = kPlaneUnit + 1,   // as well

  // Beyond the guaranteed units: drivers with fewer do without these features.
  kMoreSurfaceUnit = 8,                 // .. 11: a material's other pictures, while the camera's are bound
  kMatteUnit = kMoreSurfaceUnit,        // shared: used with the camera's picture, where no surface is drawn
  kPassersUnit = kMoreSurfaceUnit + 1,  // shared in the same way
  kSceneDepthUnit = kMoreSurfaceUnit,   // shared: used for the layer, which is drawn without the camera's picture
  kShadowUnit = 12,
};

}  // namespace kasumi
