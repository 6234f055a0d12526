// Inserts fragments into a pixel's nodes, sorted by depth; of K + 1 the farthest falls out.
#define FETCH_DEPTHS get_depths
#define FETCH_COLORS get_colors
#include "bounded_nodes/nodes.glsl"

uint with_part(uint texel, int i, uint word) { return word; }
uvec2 with_part(uvec2 texel, int i, uint word) { texel[i] = word; return texel; }
uvec4 with_part(uvec4 texel, int i, uint word) { texel[i] = word; return texel; }

void set_color_word(int i, int j, uint word) {
    int at = i * WORDS + j;
    set_colors(at / 4, with_part(get_colors(at / 4), at % 4, word));
}

void set_node(int i, Node node) {
    set_depths(i / 4, with_part(get_depths(i / 4), i % 4, node.depth));
#if NODE == NODE_8_BIT
    set_color_word(i, 0, node.color);
#elif NODE == NODE_16F
    set_color_word(i, 0, node.color.x);
    set_color_word(i, 1, node.color.y);
#else
    set_colors(i, node.color);
#endif
}

// By depth; ties by content, never by arrival.
bool nearer(Node a, Node b) {
    return a.depth < b.depth || (a.depth == b.depth && less(a.color, b.color));
}

Node node_of(Fragment fragment) {
    return Node(floatBitsToUint(fragment.z), pack(premultiplied(fragment)));
}

// Keeps the nearer of a node and `carried` in place `i`, and the other in `carried`.
void exchange(int i, inout Node carried) {
    Node kept = node_at(i);
    bool before = nearer(carried, kept);
    set_node(i, Node(before ? carried.depth : kept.depth, before ? carried.color : kept.color));
    carried = Node(before ? kept.depth : carried.depth, before ? kept.color : carried.color);
}

// Inserts a node and returns the one that falls out, which is empty while there is room.
Node insert(Node carried) {
#define EXCHANGE(i) exchange(i, carried);
    EACH_NODE(EXCHANGE)
    return carried;
}
