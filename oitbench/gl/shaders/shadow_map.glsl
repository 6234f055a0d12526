// Stochastic colored shadows: a surface is drawn with the probability that it blocks the light of one
// channel (McGuire & Mara 2017).
#include "random.glsl"
#include "shadow_blocking.glsl"

// Cells per meter of the grid on which world positions are hashed, independent of the camera. Below
// the size of a texel they are noise; in maps of tiny scenes they are therefore smaller.
float cells_per_meter() {
    float texels = pixel_focal / shown_at(far_plane);
    return max(16384.0, exp2(ceil(log2(texels))));
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
