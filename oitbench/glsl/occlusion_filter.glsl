// Averages openness over the 4 x 4 pixels of its pattern, on the surface that each pixel shows.
#include "occlusion_depth.glsl"

// Part of the radius by which a pixel's distance may differ until it does not count at all.
const float SAME = 0.25;
const float RADIUS = 1e-6 * float(RADIUS_MICROMETRES);   // m

void resolve() {
    ivec2 pixel = ivec2(gl_FragCoord.xy), last = ivec2(frame_size) - 1;
    float depth = read_occluders();
    if (depth >= 1.0) {
        discard;
    }
    float z = surface_distance(depth);
    float sum = 0.0, weights = 0.0;
    for (int k = 0; k < 16; ++k) {
        ivec2 at = clamp(pixel + ivec2(k & 3, k >> 2) - 1, ivec2(0), last);
        float away = abs(surface_distance(read_occluders(at)) - z);
        float weight = max(1.0 - away / (SAME * RADIUS), 0.0);
        sum += weight * read_raw(at);
        weights += weight;
    }
    openness = sum / weights;
}
