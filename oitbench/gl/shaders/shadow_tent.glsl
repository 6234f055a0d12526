// One direction of a tent of 15 texels, weights 1 to 8 to 1, that keeps every fourth texel. Texels
// without a surface count as 1.1 times the farthest one beneath the tent: at the far plane they
// would dominate the variance.
const int RADIUS = 7;
const int KEPT = 4;

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
    ivec2 center = ivec2(pixel.x * KEPT + KEPT / 2, pixel.y);
#else
    ivec2 last = ivec2(pixel.x, int(frame_size.y) - 1);
    ivec2 center = ivec2(pixel.x, pixel.y * KEPT + KEPT / 2);
#endif
    vec2 sum = vec2(0.0);
    float farthest = 0.0, empty = 0.0;
    for (int k = -RADIUS; k <= RADIUS; ++k) {
        ivec2 at = clamp(center + along(k), ivec2(0), last);
        vec2 texel = read_source(at);
        float weight = float(RADIUS + 1 - abs(k)) / 64.0;
        sum += weight * texel;
        empty += texel.x > 0.0 ? 0.0 : weight;
        farthest = max(farthest, texel.x);
    }
    float beyond = 1.1 * farthest;
#ifndef ACROSS
    // No surface beneath the finished tent: the map's whole range is lit.
    beyond = farthest > 0.0 ? beyond : far_plane;
#endif
    filtered = sum + empty * vec2(beyond, beyond * beyond);
}
