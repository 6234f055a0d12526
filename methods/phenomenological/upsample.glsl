// Adds the small targets to those of the frame by a joint bilateral filter (section 5.0.1): a tent of
// 7 x 7 texels. A texel's weight falls with the distance of its opaque surface from the plane of the
// opaque surface at the pixel. On the screen, planes are linear in 1/z at any obliqueness; where rays
// are parallel, in z.
#include "model.glsl"
const float TENT = 3.0;       // texels from its middle to its foot
const float KEY = 0.02;       // relative difference of distances that leaves 1/e of a weight
const float FLOOR = 1e-3;     // least weight, so that thin objects find a texel
const float STEEPEST = 0.1;   // relative difference of neighbors, of one surface seen obliquely
const float FAR = 1e-6;       // 1/m: everything farther counts as equally far as the sky

float linear(float z) { return eye.w == 0.0 ? z : 1.0 / z; }

float nearness(ivec2 pixel) {
    ivec2 within = clamp(pixel, ivec2(0), ivec2(frame_size) - 1);
    return linear(view_distance(read_opaque_depth(within)));
}

// The smaller of both differences: at an edge, the other one spans two surfaces.
float slope(ivec2 pixel, ivec2 along) {
    float middle = nearness(pixel);
    float before = middle - nearness(pixel - along);
    float after = nearness(pixel + along) - middle;
    float least = abs(before) < abs(after) ? before : after;
    return abs(least) < STEEPEST * middle ? least : 0.0;
}

// `plane` is 1/z here, 1/m, and its slope, 1/m per pixel.
float weight_of(ivec2 texel, vec2 at, vec3 plane) {
    vec2 tent = max(1.0 - abs(vec2(texel) + 0.5 - at) / TENT, vec2(0.0));
    // The pixel at which the block is sampled.
    vec2 offset = vec2(texel * SUBSAMPLE + SUBSAMPLE / 2) + 0.5 - gl_FragCoord.xy;
    float gap = abs(linear(read_small_distance(texel)) - plane.x - dot(plane.yz, offset));
    return tent.x * tent.y * (FLOOR + exp(-gap / (KEY * max(plane.x, FAR))));
}

void resolve() {
    vec2 at = gl_FragCoord.xy / float(SUBSAMPLE);
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 plane = vec3(nearness(pixel), slope(pixel, ivec2(1, 0)), slope(pixel, ivec2(0, 1)));
    ivec2 first = max(ivec2(ceil(at - TENT - 0.5)), ivec2(0));
    ivec2 last = min(ivec2(floor(at + TENT - 0.5)), (ivec2(frame_size) - 1) / SUBSAMPLE);
    vec4 layers = vec4(0.0);
    vec4 passed = vec4(0.0);    // and the variance of the blur
    vec3 bends = vec3(0.0);     // and the coverage that bends
    float total = 0.0;
    for (int y = first.y; y <= last.y; ++y) {
        for (int x = first.x; x <= last.x; ++x) {
            ivec2 texel = ivec2(x, y);
            float weight = weight_of(texel, at, plane);
            total += weight;
            layers += weight * read_small_accum(texel);
            passed.rgb += weight * read_small_beta(texel).rgb;
#ifdef EFFECT_DIFFUSION
            passed.a += weight * read_small_beta(texel).a;
#endif
#ifdef BENDS
            bends.xy += weight * read_small_delta(texel);
#if OFFSET == OFFSET_NORMALIZED
            bends.z += weight * read_small_bending(texel);
#endif
#endif
        }
    }
    accum = layers / total;
    beta = modulation(1.0 - passed.rgb / total, passed.a / total);
#ifdef BENDS
    delta = bends.xy / total;
#if OFFSET == OFFSET_NORMALIZED
    bending = bends.z / total;
#endif
#endif
}
