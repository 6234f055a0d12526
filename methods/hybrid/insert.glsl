// Inserts the fragment by depth; the farthest of K + 1 nodes is added to the tail. Fragments that
// the core does not admit are added to the tail as they are.
#include "bounded_nodes/insert.glsl"

void gather(Fragment fragment) {
    Node node = node_of(fragment);
    if (hides_nothing(node.color)) {
        return;
    }
    // While there is room, the node that falls out is empty and adds nothing.
    vec4 layer = unpack(net_opacity(fragment) < float(ADMISSION) ? node.color : insert(node).color);
    tail = half_float(tail + layer);
#if TRANSMITTANCE == TRANSMITTANCE_EXACT
    passed *= 1.0 - layer.a;
#else
    count += layer.a > 0.0 ? 1.0 : 0.0;
#endif
}
