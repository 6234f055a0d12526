// Inserts the fragment by depth; the farthest of K + 1 nodes is added to the tail.
#include "bounded_nodes/insert.glsl"

void gather(Fragment fragment) {
    Node node = node_of(fragment);
    if (hides_nothing(node.color)) {
        return;
    }
    // While there is room, the node that falls out is empty and adds nothing.
    vec4 layer = unpack(insert(node).color);
    tail = half_float(tail + layer);
    count += layer.a > 0.0 ? 1.0 : 0.0;
}
