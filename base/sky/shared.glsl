// What the texts shared with C++ call these, in GLSL ES 1.00 (base/sky/sky_text.hpp for C++).
#define real float
#define FUNCTION
