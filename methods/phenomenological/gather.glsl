// Adds one fragment to all targets, or one of particles to the small ones.
#include "layer.glsl"
#ifdef SMALL
#define accum small_accum
#define beta small_beta
#define delta small_delta
#define bending small_bending
float distance_behind() { return read_small_distance(); }
#else
float distance_behind() { return view_distance(read_opaque_depth()); }
#endif

void gather(Fragment fragment) {
    float opacity = net_opacity(fragment);
    vec4 layer = vec4(fragment.coverage * fragment.radiance, opacity);
    accum = layer * depth_weight(opacity, fragment.depth);
    float behind = distance_behind();
    float variance = 0.0;
#ifdef EFFECT_DIFFUSION
    float part = WEIGHT == WEIGHT_NET ? opacity : fragment.coverage;
    variance = storable(blur_variance(fragment.z, behind, fragment.collimation, part));
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
