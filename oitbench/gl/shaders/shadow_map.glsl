// Stochastic colored shadows with caustics: a surface is drawn with the probability that it blocks
// the light of one channel (McGuire & Mara 2017, equations 11 to 13).
#include "random.glsl"

// Cells per meter of the grid on which world positions are hashed, independent of the camera. Below
// the size of a texel they are noise; in maps of tiny scenes they are therefore smaller.
float cells_per_meter() {
    float texels = pixel_focal / (eye.w == 0.0 ? 1.0 : far_plane);
    return max(16384.0, exp2(ceil(log2(texels))));
}

// Factor on the blocked light for the refraction of a solid: less in the middle, where the caustic
// is, and more at the rim. s = 0 means no refraction, and avoids a power of zero.
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

// Fraction of each channel that the surface blocks.
vec3 kept_back(Fragment fragment) {
    vec3 kept = fragment.coverage * (1.0 - fragment.transmission);
#ifdef GRAY
    kept = vec3(dot(kept, vec3(1.0 / 3.0)));
#endif
    return min(kept * caustic_factor(fragment.index, fragment.incidence), vec3(1.0));
}

void gather(Fragment fragment) {
    vec3 part = kept_back(fragment);
#ifdef BINARY
    if (part.r <= 0.5) {
        discard;
    }
#else
    // The same number for all channels: noise stays gray.
    ivec3 cell = ivec3(floor(fragment.position * cells_per_meter()));
    float number = unit_interval(hash(uvec3(cell)).x);
    if (all(lessThanEqual(part, vec3(number)))) {
        discard;
    }
    map0 = part.r > number ? fragment.inverse_depth : 0.0;
#ifndef GRAY
    map1 = part.g > number ? fragment.inverse_depth : 0.0;
    map2 = part.b > number ? fragment.inverse_depth : 0.0;
#endif
#endif
}
