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
    vec4 surroundings[9];      // irradiance of the environment, spherical harmonics
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

// Irradiance of a surface with unit normal `n`: Ramamoorthi & Hanrahan 2001, equation 13 with the
// cosine lobe already in the coefficients.
vec3 surrounding_irradiance(vec3 n) {
    vec3 sum = surroundings[0].rgb + surroundings[1].rgb * n.y + surroundings[2].rgb * n.z +
               surroundings[3].rgb * n.x + surroundings[4].rgb * (n.x * n.y) +
               surroundings[5].rgb * (n.y * n.z) + surroundings[6].rgb * (3.0 * n.z * n.z - 1.0) +
               surroundings[7].rgb * (n.x * n.z) + surroundings[8].rgb * (n.x * n.x - n.y * n.y);
    return max(sum, vec3(0.0));
}

// Mean radiance over all directions.
vec3 surrounding_radiance() { return surroundings[0].rgb / PI; }

// Radiance from the unit direction `d`, blurred as a microfacet lobe of this roughness does.
vec3 environment_radiance(vec3 d, float roughness) {
    // GLSL does not define atan(0, 0): straight up and down, any longitude will do.
    float longitude = d.x == 0.0 && d.z == 0.0 ? 0.0 : atan(d.x, -d.z);
    vec2 uv = vec2(0.5 + longitude / (2.0 * PI), 0.5 + asin(clamp(d.y, -1.0, 1.0)) / PI);
    vec2 size = vec2(textureSize(environment_texture, 0));
    // The lobe's solid angle, about 4 pi a^2 with a = roughness^2, in texels.
    float area = roughness * roughness * roughness * roughness * size.x * size.y;
    return textureLod(environment_texture, uv, 0.5 * log2(max(area, 1.0))).rgb;
}
#endif
