// Keeps the fragment where its opacity reaches the threshold; the depth test finds the nearest.
#include "threshold.glsl"

void gather(Fragment fragment) {
    vec4 layer = premultiplied(fragment);
    if (layer.a < threshold(fragment.position) || !before_opaque(fragment, read_opaque_depth())) {
        discard;
    }
    color = vec4(layer.rgb / layer.a, 1.0);
}
