// Keeps the K nearest fragments. A fragment without effect takes no node.
#include "bounded_nodes/insert.glsl"

void gather(Fragment fragment) {
    Node node = node_of(fragment);
    if (!hides_nothing(node.color)) {
        insert(node);
    }
}
