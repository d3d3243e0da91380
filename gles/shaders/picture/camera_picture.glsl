// The camera's picture from its planes, chroma from the nearest sample, as to_rgb in base/picture.hpp.
#if defined(LAYOUT_EXTERNAL)
uniform samplerExternalOES plane_0;  // the driver converts
#else
uniform sampler2D plane_0;
#endif
#if defined(LAYOUT_NV12) || defined(LAYOUT_PLANAR)
uniform sampler2D plane_1;
#endif
#if defined(LAYOUT_PLANAR)
uniform sampler2D plane_2;
#endif
#if defined(LAYOUT_YUYV) || defined(LAYOUT_UYVY)
uniform vec2 packed_size;  // pixels; texels of plane_0 across
#endif
#if !defined(LAYOUT_RGB) && !defined(LAYOUT_BGR) && !defined(LAYOUT_GREY) && !defined(LAYOUT_EXTERNAL)
uniform mat3 yuv_to_rgb;
uniform vec3 yuv_offset;
#endif
#if defined(LAYOUT_NV12) || defined(LAYOUT_PLANAR)
uniform vec2 chroma_scale;  // pictures of odd size have half a chroma sample too many
#endif

// place: 0..1 across the picture
vec3 camera_at(vec2 place) {
#if defined(LAYOUT_RGB) || defined(LAYOUT_EXTERNAL)
  return texture2D(plane_0, place).rgb;
#elif defined(LAYOUT_BGR)
  return texture2D(plane_0, place).bgr;
#elif defined(LAYOUT_GREY)
  return texture2D(plane_0, place).rrr;
#else
#if defined(LAYOUT_NV12)
  vec4 chroma = texture2D(plane_1, place * chroma_scale);
#if defined(CHROMA_IN_GREEN)
  vec3 yuv = vec3(texture2D(plane_0, place).r, chroma.rg);
#else
  vec3 yuv = vec3(texture2D(plane_0, place).r, chroma.ra);
#endif
#elif defined(LAYOUT_PLANAR)
  vec2 chroma = place * chroma_scale;
  vec3 yuv = vec3(texture2D(plane_0, place).r, texture2D(plane_1, chroma).r, texture2D(plane_2, chroma).r);
#else
  float column = floor(place.x * packed_size.x);
  float pair = floor(column / 2.0);
  vec4 texel = texture2D(plane_0, vec2((pair + 0.5) / packed_size.y, place.y));
#if defined(LAYOUT_YUYV)
  vec3 yuv = vec3(mix(texel.r, texel.b, column - 2.0 * pair), texel.g, texel.a);
#else
  vec3 yuv = vec3(mix(texel.g, texel.a, column - 2.0 * pair), texel.r, texel.b);
#endif
#endif
  return yuv_to_rgb * (yuv - yuv_offset);
#endif
}
