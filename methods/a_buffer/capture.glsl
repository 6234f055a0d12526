// Puts one fragment at the head of its pixel's list.
#include "node.glsl"

void gather(Fragment fragment) {
    uint node = allocate_nodes();
    if (node != NONE) {
        set_nodes_next(node, exchange_heads_first(pixel_index(), node));
        store_layer(node, fragment.coverage * fragment.radiance, transmittance(fragment),
                    net_opacity(fragment), fragment.z);
    }
}
