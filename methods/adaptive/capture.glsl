// Keeps every fragment in its pixel's list.
#include "linked_lists/append.glsl"
#include "depth.glsl"

void gather(Fragment fragment) {
    append(fragment, curve_depth(fragment));
}
