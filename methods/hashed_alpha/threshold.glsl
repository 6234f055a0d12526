// A number uniform in [0, 1] that belongs to a place in the scene; Wyman & McGuire 2017.
#include "oitbench/random.glsl"

float hash_cell(vec3 cell) {
    // Thresholds of the first frame are fixed in the scene; each further frame has its own.
    uvec3 stream = frame_number == 0u ? uvec3(0u) : hash(uvec3(frame_number));
    return unit_interval(hash(uvec3(ivec3(floor(cell))) + stream).x);
}

float threshold(vec3 position) {
    float pixel = max(length(dFdx(position)), length(dFdy(position)));
    float level = -log2(max(SCALE * pixel, 1e-20));
    float coarse = hash_cell(exp2(floor(level)) * position);
    float fine = hash_cell(exp2(ceil(level)) * position);
    float share = fract(level);
    float x = mix(coarse, fine, share);
    // The distribution function of a mix of two uniform numbers makes the mix uniform again.
    float a = min(share, 1.0 - share);
    float edge = max(2.0 * a * (1.0 - a), 1e-20);
    float even = x < a ? x * x / edge
        : x < 1.0 - a ? (x - 0.5 * a) / (1.0 - a)
        : 1.0 - (1.0 - x) * (1.0 - x) / edge;
    return clamp(even, 1e-6, 1.0);
}
