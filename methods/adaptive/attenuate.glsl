// The background is seen through all layers.
#include "nodes.glsl"

void resolve() {
    unpack_nodes(TARGETS - 1, read_nodes(TARGETS - 1));
    color = vec4(background_factor(total()), 1.0);
}
