// Adds one fragment to all targets.
#include "layer.glsl"

void gather(Fragment fragment) {
    float opacity = net_opacity(fragment);
    vec4 layer = vec4(fragment.coverage * fragment.radiance, opacity);
    accum = layer * depth_weight(opacity, fragment.depth);
    float behind = view_distance(read_opaque_depth());
    vec3 removed = 1.0 - transmittance(fragment);
#ifdef EFFECT_DIFFUSION
    float part = WEIGHT == WEIGHT_NET ? opacity : fragment.coverage;
    float variance = blur_variance(fragment.z, behind, fragment.collimation, part);
    beta = vec4(removed, storable(variance));
#elif PRECISION == PRECISION_PAPER
    beta = removed;
#else
    beta = vec4(removed, 0.0);
#endif
#ifdef EFFECT_REFRACTION
    float bends = OFFSET == OFFSET_NET ? opacity : fragment.coverage;
    delta = refraction_offset(fragment, behind) * bends / UNIT;
#if OFFSET == OFFSET_NORMALIZED
    bending = fragment.index == 1.0 ? 0.0 : bends;
#endif
#endif
}
