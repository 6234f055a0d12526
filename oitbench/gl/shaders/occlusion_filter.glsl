// Averages openness over its pattern of 4 x 4 pixels, on the surface that each pixel shows. The box
// is centered: the fifth row is the first one of the next pattern, and each counts half.

// Difference in distance, as a fraction of the radius, at which a pixel no longer counts.
const float SAME = 0.25;

void resolve() {
    ivec2 pixel = ivec2(gl_FragCoord.xy), last = ivec2(frame_size) - 1;
    float depth = read_occluders();
    if (depth <= 0.0) {
        discard;
    }
    float z = view_distance(depth);
    float sum = 0.0, weights = 0.0;
    for (int y = -2; y <= 2; ++y) {
        for (int x = -2; x <= 2; ++x) {
            ivec2 at = clamp(pixel + ivec2(x, y), ivec2(0), last);
            float away = abs(view_distance(read_occluders(at)) - z);
            float weight = max(1.0 - away / (SAME * RADIUS), 0.0);
            weight *= (abs(x) == 2 ? 0.5 : 1.0) * (abs(y) == 2 ? 0.5 : 1.0);
            sum += weight * read_raw(at);
            weights += weight;
        }
    }
    openness = sum / weights;
}
