// Adds one fragment to all targets, or one of particles to the small ones.
#include "layer.glsl"

// Variance of the fragment's blur, in stored units.
float variance_of(Fragment fragment, float behind, float opacity) {
#if WEIGHT == WEIGHT_OPTICAL
    // As a part of a medium; all light that leaves a sheet of coverage one has passed it once.
    return medium_blur_variance(fragment.z, behind, fragment.collimation)
           * min(optical_depth(fragment.coverage), 1.0);
#else
    float part = WEIGHT == WEIGHT_NET ? opacity : fragment.coverage;
    return blur_variance(fragment.z, behind, fragment.collimation) * part * part;
#endif
}

void gather(Fragment fragment) {
    float opacity = net_opacity(fragment);
    vec4 layer = vec4(fragment.coverage * fragment.radiance, opacity);
    accum = layer * depth_weight(opacity, fragment.depth);
    float behind = distance_behind();
    float variance = 0.0;
#ifdef EFFECT_DIFFUSION
    variance = storable(variance_of(fragment, behind, opacity));
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
