// GLSL ES 1.00 definitions of the names used in sources shared with C++ (base/sky/sky_text.hpp has the C++ ones).
#define real float
#define FUNCTION
