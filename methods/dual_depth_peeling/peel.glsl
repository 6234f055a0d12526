// Composites the nearest and the farthest layer left, and finds the next ones between them.
// An odd last layer is both: it is taken once, as the nearest.
#include "curves.glsl"

void gather(Fragment fragment) {
    float near = read_edges().x;
    float far = -read_edges().y;
    float depth = fragment.inverse_depth;
    if (depth > near || depth < far || fragment.coverage <= 0.0) {
        discard;
    }
    bool nearest = depth == near;
    bool farthest = !nearest && depth == far;
    for (int i = 0; i < CURVES; ++i) {
        vec4 layer = premultiplied(fragment);
#ifdef EFFECT_COLORED_TRANSMISSION
        layer.a = 1.0 - transmittance(fragment)[i];
#endif
        set_front(i, layer * float(nearest));
        set_back(i, layer * float(farthest));
    }
    bounds = nearest || farthest ? vec2(-1.0) : vec2(depth, -depth);
}
