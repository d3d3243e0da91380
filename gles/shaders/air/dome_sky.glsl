// The sky of the selected model.
#include "sky_text.glsl"

uniform vec3 sun;
uniform vec3 sun_luminance;
uniform float exposure;
#if defined(PREETHAM)
uniform PerezSky perez;
#elif defined(HOFFMAN_PREETHAM) || defined(NIELSEN)
uniform OlderAir older;
#else
uniform DomeSky sky;
#endif

vec3 sky_light(vec3 view) {
#if defined(PREETHAM)
  return preetham_sky(perez, view.z, dot(view, sun));
#elif defined(HOFFMAN_PREETHAM)
  return hoffman_preetham_sky(older, view.z, dot(view, sun));
#elif defined(NIELSEN)
  return nielsen_sky(older, view.z, dot(view, sun));
#else
  return dome_sky_light(sky, view.z, dot(view, sun));
#endif
}

vec3 shown(vec3 light, vec3 view) {
  return srgb_encoded(tone_mapped(light + sun_glare(sun_luminance, length(view - sun)), exposure));
}
