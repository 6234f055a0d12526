// The scene's lights and their shadows; filled by oitbench/gl/shading/lighting.py.
const float PI = 3.14159265358979;

struct Beam {
    mat4 to_map;      // world to the clip space of its shadow maps
    vec4 place;       // a spot's position and 1, or the direction toward the light and 0
    vec4 axis;        // a spot's unit axis, and half its angle in radians
    vec4 color;       // intensity or irradiance; world width of a map's texel at one meter
    vec4 distance;    // dot product with (position, 1) is the distance along the axis, m
    vec4 range;       // near and far plane of its maps, m; fraction of the half angle that fades
};

layout(std140, binding = 1) uniform Lights {
    Beam beams[BEAMS + 1];     // one more than needed: GLSL has no empty arrays
    vec4 surroundings;         // mean radiance of the environment
};

#include "shadows.glsl"

// Unit vector toward the light.
vec3 toward_light(int i, vec3 position) {
    return normalize(beams[i].place.xyz - beams[i].place.w * position);
}

// Irradiance on a surface that faces the light, without shadows.
vec3 irradiance(int i, vec3 position) {
    if (beams[i].place.w == 0.0) {
        return beams[i].color.rgb;
    }
    vec3 offset = position - beams[i].place.xyz;
    // Drivers round acos coarsely near one.
    vec3 toward = normalize(offset);
    float angle = atan(length(cross(toward, beams[i].axis.xyz)), dot(toward, beams[i].axis.xyz));
    float half_angle = beams[i].axis.w;
    float falloff = clamp((half_angle - angle) / (beams[i].range.z * half_angle), 0.0, 1.0);
    return beams[i].color.rgb * falloff / max(dot(offset, offset), 1e-8);
}

#ifdef ENVIRONMENT
uniform sampler2D environment_texture;   // latitude and longitude, first row down (-y)
uniform sampler2DArray means_texture;    // latitude and longitude, first row up, first column ahead
#ifdef LOBES
uniform sampler2D lobes_texture;         // by n.v, a row for each lobe
#endif

// To the right of straight ahead (-z), in turns. GLSL does not define atan(0, 0): straight up and
// down, any longitude will do.
float longitude(vec3 d) {
    return d.x == 0.0 && d.z == 0.0 ? 0.0 : atan(d.x, -d.z) / (2.0 * PI);
}

// Above the horizon, in half turns. Drivers round asin coarsely.
float latitude(vec3 d) { return atan(d.y, length(d.xz)) / PI; }

// Radiance from the unit direction `d`.
vec3 environment_radiance(vec3 d) {
    vec2 uv = vec2(0.5 + longitude(d), 0.5 + latitude(d));
    return textureLod(environment_texture, uv, 0.0).rgb;
}

// Mean radiance around the unit direction `d`, weighted as layer `layer` is.
vec3 mean_radiance(vec3 d, int layer) {
    vec2 size = vec2(textureSize(means_texture, 0).xy);
    float down = (0.5 - latitude(d)) * (size.y - 1.0);
    vec2 uv = vec2(longitude(d) + 0.5 / size.x, (down + 0.5) / size.y);
    return textureLod(means_texture, vec3(uv, float(layer)), 0.0).rgb;
}

// Irradiance of a surface with unit normal `n`, divided by pi.
vec3 surrounding_light(vec3 n) { return mean_radiance(n, 0); }

// Light that a microfacet lobe with F0 = `reflectance` reflects toward `v`: the split sum of Karis
// 2013, with the lobe around its mean direction.
vec3 mirrored(int lobe, float reflectance, vec3 n, vec3 v) {
#ifdef LOBES
    ivec2 size = textureSize(lobes_texture, 0);
    float nv = clamp(dot(n, v), 0.0, 1.0);
    vec2 uv = vec2((nv * float(size.x - 1) + 0.5) / float(size.x),
                   (float(lobe) - 0.5) / float(size.y));
    vec4 fit = textureLod(lobes_texture, uv, 0.0);
    vec3 middle = normalize(fit.z * reflect(-v, n) + fit.w * n);
    return (reflectance * fit.x + fit.y) * mean_radiance(middle, lobe);
#else
    return vec3(0.0);
#endif
}
#endif
