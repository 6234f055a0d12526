// Keeps every fragment in its pixel's list, by view distance.
#include "linked_lists/append.glsl"

void gather(Fragment fragment) {
    append(fragment, fragment.z);
}
