// Adds the optical depth of a surface to the slice of space that it lies in, in fixed point: the sum
// does not depend on the order of fragments.
#include "shadow_blocking.glsl"

// Least light that passes a surface: 2^-16.
const float FAINT = 1.0 / 65536.0;

uint fixed_point(float part) { return uint(-log(max(1.0 - part, FAINT)) * UNIT + 0.5); }

void gather(Fragment fragment) {
    vec3 part = kept_back(fragment);
    float slice = floor((view_distance(fragment.inverse_depth) - FIRST) / THICKNESS);
    uint place = uint(clamp(slice, 0.0, float(LIGHT_PLANES - 2)));
    uint i = place * frame_size.x * frame_size.y + pixel_index();
    add_slices_depth0(i, fixed_point(part.r));
#ifndef GRAY
    add_slices_depth1(i, fixed_point(part.g));
    add_slices_depth2(i, fixed_point(part.b));
#endif
}
