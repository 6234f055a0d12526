// A number uniform in [0, 1] that belongs to a place in the scene; Wyman & McGuire 2017.
float hash_pair(vec2 p) {
    return fract(1.0e4 * sin(17.0 * p.x + 0.1 * p.y) * (0.1 + abs(sin(13.0 * p.y + p.x))));
}

float hash_cell(vec3 p) {
    return hash_pair(vec2(hash_pair(p.xy), p.z));
}

float threshold(vec3 position) {
    float pixel = max(length(dFdx(position)), length(dFdy(position)));
    float level = -log2(max(SCALE * pixel, 1e-20));
    float coarse = hash_cell(floor(exp2(floor(level)) * position));
    float fine = hash_cell(floor(exp2(ceil(level)) * position));
    float share = fract(level);
    float x = mix(coarse, fine, share);
    // The distribution function of the mix of two uniform numbers makes it uniform again.
    float a = min(share, 1.0 - share);
    float edge = max(2.0 * a * (1.0 - a), 1e-20);
    float uniformly = x < a ? x * x / edge
        : x < 1.0 - a ? (x - 0.5 * a) / (1.0 - a)
        : 1.0 - (1.0 - x) * (1.0 - x) / edge;
    return clamp(uniformly, 1e-6, 1.0);
}
