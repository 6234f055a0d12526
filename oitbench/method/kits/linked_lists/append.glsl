// Puts a fragment at the head of its pixel's list.
#include "linked_lists/record.glsl"

void append(Fragment fragment, float depth) {
    uint node = allocate_nodes();
    if (node != NONE) {
        set_nodes_next(node, exchange_heads_first(pixel_index(), node));
        store_layer(node, with_mask(depth), fragment.coverage * fragment.radiance,
                    transmittance(fragment), net_opacity(fragment));
    }
}
