// Turns a list round in its links, so that it begins with the fragment that came first.
#include "linked_lists/record.glsl"

void resolve() {
    if (!list_owner()) {
        return;
    }
    uint node = heads_first(pixel_index());
    uint behind = NONE;
    while (node != NONE) {
        uint next = nodes_next(node);
        set_nodes_next(node, behind);
        behind = node;
        node = next;
    }
    set_heads_first(pixel_index(), behind);
}
