// The nodes over the background.
#include "bounded_composite.glsl"

void resolve() {
    color = composite_nodes();
}
