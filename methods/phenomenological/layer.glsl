// The contribution of one layer (McGuire & Mara 2017, sections 4.3 to 4.5 and listing 1).
#include "model.glsl"

#ifdef SMALL
#define accum small_accum
#define beta small_beta
#define delta small_delta
#define bending small_bending
float distance_behind() { return read_small_distance(); }
#else
float distance_behind() { return view_distance(read_opaque_depth()); }
#endif

// Focal length in pixels of the frame, also where a texel is a block of pixels.
float focal_length() {
#ifdef SMALL
    return pixel_focal * float(SUBSAMPLE);
#else
    return pixel_focal;
#endif
}

const float AGREES = 2.5;   // m

// The longest offset, pixels: beyond any picture, and some layers' sum still fits a half float.
const float LONGEST = 8192.0;

// Equation 5, or that of the authors' engine.
float depth_weight(float opacity, float depth) {
#if DEPTH_WEIGHT == DEPTH_WEIGHT_G3D
    float near_part = 1.0 - 0.99 * depth;
    return clamp(opacity * clamp(1e4 * near_part * near_part * near_part, 1e-3, 1.0), 1e-3, 150.0);
#else
    float x = 10.0 * (1.0 - 0.99 * depth) * opacity;
    return clamp(x * x * x, 0.01, 30.0);
#endif
}

// Variance of the blur by a layer of alpha = 1, in stored units: the square of equation 7.
float blur_variance(float distance, float behind, float collimation) {
    float spread = 1.0 - K1 / (K1 + abs(behind - distance));
    float blur = focal_length() * K0 * (1.0 - collimation) * spread / shown_at(max(distance, 1e-6));
    return (blur / UNIT) * (blur / UNIT);
}

// The same for a medium, per optical depth: light spreads by slopes of one deviation at any distance.
// Equation 7 would grow without bound toward the eye. Both agree at z = |z_B - z| = AGREES.
float medium_blur_variance(float distance, float behind, float collimation) {
    float gap = abs(behind - distance);
    float slope = 2.0 * K0 / (K1 + AGREES) * (1.0 - collimation);
    float blur = focal_length() * slope * gap / shown_at(max(distance + gap, 1e-6));
    return (blur / UNIT) * (blur / UNIT);
}

// Optical depth of a coverage; a coverage that rounds to one has that of the next smaller float.
float optical_depth(float coverage) { return -log(max(1.0 - coverage, 6e-8)); }

// The same as targets can hold it: the least blur does not round to none.
float storable(float variance) { return variance > 0.0 ? max(variance, LEAST) : 0.0; }

// Where the view ray, bent at the surface, meets a plane behind it, in pixels from here. Light that
// leaves a solid along the view ray came, by reversibility, along the ray that the same surface bends
// into the solid. Leaving undoes what entering did, so both offsets have the same length.
vec2 refraction_offset(Fragment fragment, float behind) {
    if (fragment.index == 1.0) {
        return vec2(0.0);
    }
    vec3 position = (world_to_camera * vec4(fragment.position, 1.0)).xyz;
    vec3 normal = mat3(world_to_camera) * fragment.normal;
    // GLSL gives zero where all light is reflected.
    vec3 seen = eye.w == 0.0 ? vec3(0.0, 0.0, -1.0) : normalize(position);
    vec3 bent = refract(seen, normal, 1.0 / fragment.index);
    if (bent.z > -1e-3) {
        return vec2(0.0);
    }
#if REACH == REACH_FIXED
    float reach = DZ;
#else
    float reach = clamp(behind - fragment.z, 0.0, FARTHEST);
#endif
    vec3 target = position + reach * bent / abs(bent.z);
    // Differences first: both projections are large beside their distance.
    vec2 offset = focal_length() * (target.xy / shown_at(-target.z) - position.xy / shown_at(-position.z));
    offset = fragment.entering ? offset : -offset;
    return clamp(offset, vec2(-LONGEST), vec2(LONGEST));
}
