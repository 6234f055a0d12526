// Inserts the fragment by depth; the farthest of K + 1 nodes is merged into the one before it.
#include "bounded_nodes/insert.glsl"

void gather(Fragment fragment) {
    Node node = node_of(fragment);
    if (hides_nothing(node.color)) {
        return;
    }
    // While there is room, the node that falls out is empty, and merging it changes nothing.
    vec4 behind = unpack(insert(node).color);
    Node last = node_at(K - 1);
    vec4 front = unpack(last.color);
    last.color = pack(front + (1.0 - front.a) * behind);
    set_node(K - 1, last);
}
