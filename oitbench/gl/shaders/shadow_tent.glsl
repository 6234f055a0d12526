// One direction of a tent that keeps one of DOWNSAMPLING texels; for four, its 15 weights are 1 to 8 to
// 1. In the published form, texels without a surface count as 1.1 times the farthest one beneath the
// tent: at the far plane they would dominate the variance.
const int RADIUS = 2 * DOWNSAMPLING - 1;
const float TOTAL = float((RADIUS + 1) * (RADIUS + 1));
#ifdef OCCLUDERS
#define MOMENTS vec4
#else
#define MOMENTS vec2
#endif

ivec2 along(int offset) {
#ifdef ACROSS
    return ivec2(offset, 0);
#else
    return ivec2(0, offset);
#endif
}

void resolve() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
#ifdef ACROSS
    ivec2 last = ivec2(int(frame_size.x) - 1, pixel.y);
    ivec2 center = ivec2(pixel.x * DOWNSAMPLING + DOWNSAMPLING / 2, pixel.y);
#else
    ivec2 last = ivec2(pixel.x, int(frame_size.y) - 1);
    ivec2 center = ivec2(pixel.x, pixel.y * DOWNSAMPLING + DOWNSAMPLING / 2);
#endif
    MOMENTS sum = MOMENTS(0.0);
    float farthest = 0.0, empty = 0.0;
    for (int k = -RADIUS; k <= RADIUS; ++k) {
        ivec2 at = clamp(center + along(k), ivec2(0), last);
        MOMENTS texel = read_source(at);
        float weight = float(RADIUS + 1 - abs(k)) / TOTAL;
        sum += weight * texel;
        empty += texel.x > 0.0 ? 0.0 : weight;
        farthest = max(farthest, texel.x);
    }
#ifdef OCCLUDERS
    filtered = sum;
#else
    float beyond = 1.1 * farthest;
#ifndef ACROSS
    // No surface beneath the finished tent: the map's whole range is lit.
    beyond = farthest > 0.0 ? beyond : far_plane;
#endif
    filtered = sum + empty * vec2(beyond, beyond * beyond);
#endif
}
