// Sunlight on surfaces.
uniform vec3 sun_direction;
uniform vec3 sun_light;        // irradiance / pi
uniform mat3 albedo_to_channels;

vec3 in_channels(vec3 reflectance) { return clamp(albedo_to_channels * reflectance, 0.0, 1.0); }

// Irradiance / pi on a surface of normal n.
vec3 from_sun(vec3 n) { return sun_light * max(dot(n, sun_direction), 0.0); }
