// Which texture unit holds what, throughout the room. A unit that two share has both names, with the reason.
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
  kNoiseUnit = kSurfaceUnit,  // shared: noise goes with the camera's picture, where no surface is drawn

  // Beyond the promise: a driver with fewer goes without what they hold.
  kMoreSurfaceUnit = 8,                // .. 11: a material's other pictures, beside the camera's
  kSceneDepthUnit = kMoreSurfaceUnit,  // shared: it goes with the layer, which is drawn without the camera's picture
  kShadowUnit = 12,
};

}  // namespace kasumi
