// Adds the medium to all targets, or to the small ones: the sum over slices, each as a plane would
// add it.
#include "oitbench/fragment.glsl"
#include "layer.glsl"
#include "oitbench/march.glsl"

void resolve() {
    float behind = distance_behind();
    Path path = path_through_medium(behind);
    vec4 sum = vec4(0.0);
    float passed = 1.0, variance = 0.0, part = jitter();
    for (int k = 0; k < STEPS; ++k) {
        Slice slice = slice_of(path, k, STEPS, part, LIGHT_STEPS);
        float weight = depth_weight(slice.coverage, window_depth(inverse_depth_at(slice.z)));
        sum += weight * slice.coverage * vec4(slice.radiance, 1.0);
        passed *= 1.0 - slice.coverage;
#ifdef EFFECT_DIFFUSION
        // In proportion to optical depth, whatever the number of slices.
        variance += medium_blur_variance(slice.z, behind, medium_color.a)
                    * optical_depth(slice.coverage);
#endif
    }
    accum = sum;
    beta = modulation(vec3(1.0 - passed), storable(variance));
}
