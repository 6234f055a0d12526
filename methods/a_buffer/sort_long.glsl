// Sorts the lists that are too long for a batch, before each sample goes through them.
#include "sort_list.glsl"

void resolve() {
    if (!list_owner()) {
        return;
    }
    uint head = heads_first(pixel_index());
    int count = 0;
    for (uint node = head; node != NONE && count <= BATCH; node = nodes_next(node)) {
        ++count;
    }
    if (count > BATCH) {
        set_heads_first(pixel_index(), sort_list(head));
    }
}
