// The nodes over the background.
#include "bounded_nodes/composite.glsl"

void resolve() {
    color = composite_nodes();
}
