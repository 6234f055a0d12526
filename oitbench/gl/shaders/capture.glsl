// Keeps every fragment in its pixel's list, by view distance.
#include "list_capture.glsl"

void gather(Fragment fragment) {
    append(fragment, fragment.z);
}
