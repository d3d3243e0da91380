// The camera's saturation (AirlightGrid::saturation), done to the object as the camera did it to the rest. Of the light
// times the pixel's coverage, too.
#if defined(SATURATED)
uniform float saturation;
const vec3 kLuminance = vec3(0.2126, 0.7152, 0.0722);
vec3 saturated(vec3 light) { return max(mix(vec3(dot(light, kLuminance)), light, saturation), 0.0); }
#endif
