// Stochastic colored shadows with caustics: a surface is kept with the probability that it keeps
// back the light of one channel (McGuire & Mara 2017, equations 11 to 13).
#include "random.glsl"

// Steps a metre of the grid on which world positions are hashed: finer than a map's texel, and
// the same wherever the camera is.
const float GRID = 16384.0;

// What the flow of light is multiplied by through the bend of a solid: less in the middle, where the
// caustic is, and more at the rim. s = 0 means no bend, and no power of zero.
float caustic_factor(float index, float cosine) {
#ifdef EFFECT_CAUSTICS
    float s = clamp(0.5 * (index - 1.0), 0.0, 1.0);
    if (s > 0.0) {
        float middle = pow(clamp(cosine, 1e-4, 1.0), 128.0 * s * s);
        return 1.0 + (1.0 - 2.0 * middle) * pow(s, 0.2);
    }
#endif
    return 1.0;
}

void gather(Fragment fragment) {
    vec3 kept = fragment.coverage * (1.0 - fragment.transmission);
#ifdef GREY
    float part = dot(kept, vec3(1.0 / 3.0));
#else
    float part = kept[iteration];
#endif
    part = min(1.0, part * caustic_factor(fragment.index, fragment.incidence));
#ifdef BINARY
    float threshold = 0.5;
#else
    // The same number for all channels: noise stays grey.
    ivec3 cell = ivec3(floor(fragment.position * GRID));
    float threshold = unit_interval(hash(uvec3(cell)).x);
#endif
    if (part <= threshold) {
        discard;
    }
}
