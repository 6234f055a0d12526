// Keeps every fragment in its pixel's list.
#include "list_capture.glsl"
#include "depth.glsl"

void gather(Fragment fragment) {
    append(fragment, curve_depth(fragment));
}
