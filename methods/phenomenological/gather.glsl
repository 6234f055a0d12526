// Adds one fragment to all targets, or one of particles to the small ones.
#include "layer.glsl"

// Factor on the variance of the blur by a layer of alpha = 1.
float blur_part(float coverage, float opacity) {
#if WEIGHT == WEIGHT_OPTICAL
    return min(optical_depth(coverage), 1.0);
#elif WEIGHT == WEIGHT_NET
    return opacity * opacity;
#else
    return coverage * coverage;
#endif
}

void gather(Fragment fragment) {
    float opacity = net_opacity(fragment);
    vec4 layer = vec4(fragment.coverage * fragment.radiance, opacity);
    accum = layer * depth_weight(opacity, fragment.depth);
    float behind = distance_behind();
    float variance = 0.0;
#ifdef EFFECT_DIFFUSION
    variance = storable(blur_variance(fragment.z, behind, fragment.collimation)
                        * blur_part(fragment.coverage, opacity));
#endif
    beta = modulation(1.0 - transmittance(fragment), variance);
#ifdef EFFECT_REFRACTION
    float bends = OFFSET == OFFSET_NET ? opacity : fragment.coverage;
    delta = refraction_offset(fragment, behind) * bends / UNIT;
#if OFFSET == OFFSET_NORMALIZED
    bending = fragment.index == 1.0 ? 0.0 : bends;
#endif
#endif
}
