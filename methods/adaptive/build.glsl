// Inserts the fragment into its pixel's curve.
#include "nodes.glsl"
#include "depth.glsl"

void gather(Fragment fragment) {
    float factor = served_factor(transmittance(fragment));
    if (factor < 1.0) {
        begin_curve();
        for (int i = 0; i < TARGETS; ++i) {
            unpack_nodes(i, get_nodes(i));
        }
        insert(packed_depth(curve_depth(fragment)), factor);
        for (int i = 0; i < TARGETS; ++i) {
            set_nodes(i, packed_nodes(i));
        }
    }
}
