// A picture in which no person can be recognised, however near.
#pragma once

#include "base/image.hpp"
#include "base/picture.hpp"

namespace kasumi {

// As many pixels along the longer side, whatever the size of the picture.
constexpr int kBlurredPixels = 32;

// The picture by its Gaussian means, 32 along the longer side; sigma is the distance between two of them. Light and
// dark closer together than 4 of these pixels lose seven tenths of their contrast, closer than 2 all of it: so a face
// that fills the height of the screen keeps 4 cycles across at most, where recognising people takes 8 to 16, and a face
// of any visitor who stands in a landscape keeps less than one. Since the means leave out what lies between them, no
// number of such pictures adds up to a sharper one.
Image<Rgb8> blurred_beyond_recognition(const Image<Rgb8>& picture);

}  // namespace kasumi
