// The core over the tail's weighted average over the background.

// The part of the pixel that the tail hides; `sum` has its sum of opacities.
float covered_by_tail(vec4 sum) {
#if TRANSMITTANCE == TRANSMITTANCE_EXACT
    return 1.0 - read_passed();
#else
    float layers = max(read_count(), 1.0);
    return 1.0 - pow(max(1.0 - sum.a / layers, 0.0), layers);
#endif
}

#include "bounded_nodes/composite.glsl"

void resolve() {
    vec4 core = composite_nodes();
    vec4 sum = read_tail();
    float covered = covered_by_tail(sum);
    // Where next to nothing hides, light adds up.
    vec3 light = sum.rgb * (sum.a > 1e-4 ? covered / sum.a : 1.0);
    color = core + (1.0 - core.a) * vec4(light, covered);
}
