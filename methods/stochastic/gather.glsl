// Adds the fragment by the fraction of samples at which it is visible.
#if CORRECTION != CORRECTION_DEPTH
#include "mask.glsl"
#endif

// Rasterized with several samples, a surface's distance at a pixel's center differs from that
// with one by some last bits (up to 2e-6 of it, on surfaces seen edge on).
const float AGAIN = MSAA > 1 ? 1.0 - 1.0 / 262144.0 : 1.0;

void gather(Fragment fragment) {
    vec4 seen = vec4(0.0);
    vec4 z = vec4(fragment.z * AGAIN);
#if CORRECTION == CORRECTION_DEPTH
    for (int i = 0; i < QUADS; ++i) {
        seen += vec4(lessThanEqual(z, read_depths(i)));
    }
    vec4 layer = premultiplied(fragment);
#else
    uint taken = mask(fragment);
    for (int i = 0; i < QUADS; ++i) {
        bvec4 mine = notEqual((uvec4(taken) >> uint(4 * i)) & uvec4(1u, 2u, 4u, 8u), uvec4(0u));
        vec4 kept = vec4(lessThanEqual(z, read_depths(i)));
        seen += mix(vec4(0.0), kept, mine);
    }
    // Radiance of a sample: its mean over the fraction o of samples is alpha L.
    vec4 layer = premultiplied(fragment) / max(net_opacity(fragment), 1e-20);
#endif
    sum = layer * (dot(seen, vec4(1.0)) / float(4 * QUADS * ROUNDS));
}
