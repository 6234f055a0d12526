// Merges faint front layers into node 0, and inserts the others into the nodes behind it.
#include "bounded_nodes/insert.glsl"

// Keeps two nodes as one, in place `i`.
void merge(int i, Node one, Node other) {
    bool before = nearer(one, other);
    vec4 front = unpack(before ? one.color : other.color);
    vec4 behind = unpack(before ? other.color : one.color);
    set_node(i, Node(min(one.depth, other.depth), pack(front + (1.0 - front.a) * behind)));
}

void gather(Fragment fragment) {
    Node node = node_of(fragment);
    vec2 nearest = read_strong();
    if (hides_nothing(node.color) || fragment.z > nearest.y) {
        return;
    }
    if (fragment.z < nearest.x) {
        merge(0, node, node_at(0));
        return;
    }
    // Of K nodes the farthest falls out; while there is room, it is empty.
#define EXCHANGE_BEHIND(i) if (i > 0) { exchange(i, node); }
    EACH_NODE(EXCHANGE_BEHIND)
    merge(K - 1, node_at(K - 1), node);
}
