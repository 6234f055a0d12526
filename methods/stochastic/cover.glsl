// Writes the fragment's distance to the samples it takes; blending keeps the nearest of each.
#include "mask.glsl"

const float FAR = 3.4028234663852886e38;

void gather(Fragment fragment) {
    uint taken = mask(fragment);
    for (int i = 0; i < QUADS; ++i) {
        uint bits = taken >> uint(4 * i);
        bvec4 mine = notEqual(uvec4(bits) & uvec4(1u, 2u, 4u, 8u), uvec4(0u));
        set_depths(i, mix(vec4(FAR), vec4(fragment.z), mine));
    }
}
