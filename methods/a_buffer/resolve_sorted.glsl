// Composites a list front to back. A list of up to BATCH records is sorted in registers; a longer
// one, or one with equal depths, whose order depends on content, in memory.
#include "sort_list.glsl"
#include "network.glsl"

const float FAR = 3.4028235e38;
vec3 sum = vec3(0.0);
vec3 visible = vec3(1.0);

void composite(Layer layer) {
    sum += visible * layer_color(layer);
    visible *= layer_factor(layer);
}

void composite_list(uint node) {
    for (; node != NONE; node = list_next(node)) {
        Layer layer = load_layer(node);
        if (layer_seen(layer)) {
            composite(layer);
        }
    }
}

// Sorts the batch from record `node` on; returns whether that is all, and all depths differ.
bool sort_in_registers(uint node) {
    for (int i = 0; i < BATCH; ++i) {
        batch_depth[i] = node != NONE ? nodes_depth(node) : FAR;
        batch_node[i] = node;
        node = node != NONE ? list_next(node) : NONE;
    }
    sort_batch();
    bool distinct = node == NONE;
    for (int i = 1; i < BATCH; ++i) {
        bool equal = batch_depth[i] == batch_depth[i - 1] && batch_node[i] != NONE;
        distinct = distinct && !equal;
    }
    return distinct;
}

void resolve() {
    uint first = list_first();
#if MSAA == 1
    if (sort_in_registers(first)) {
        for (int i = 0; i < BATCH; ++i) {
            if (batch_node[i] != NONE) {
                composite(load_layer(batch_node[i], batch_depth[i]));
            }
        }
    } else {
        composite_list(sort_list(first));
    }
#else
    composite_list(first);  // sorted once for all samples, by sort_all.glsl
#endif
    color = vec4(sum, 1.0);
    color_factor = vec4(visible, 0.0);
}
