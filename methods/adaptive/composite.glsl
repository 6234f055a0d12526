// Adds the fragment as far as the curve lets it be seen.
#include "nodes.glsl"
#include "depth.glsl"

void gather(Fragment fragment) {
    for (int i = 0; i < TARGETS; ++i) {
        unpack_nodes(i, read_nodes(i));
    }
    float visible = visibility(packed_depth(curve_depth(fragment)));
    color = vec4(fragment.coverage * fragment.radiance * visible * served(), 0.0);
}
