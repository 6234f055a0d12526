// Composites a pixel's nodes front to back; empty ones hide nothing.
#define FETCH_DEPTHS read_depths
#define FETCH_COLORS read_colors
#include "bounded_nodes/nodes.glsl"

vec4 composite_nodes() {
    vec4 sum = vec4(0.0);
#define COMPOSITE(i) sum += (1.0 - sum.a) * unpack(node_at(i).color);
    EACH_NODE(COMPOSITE)
    return sum;
}
