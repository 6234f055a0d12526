// Composites a list front to back: a short one is sorted in local arrays, a long one in its links.
#include "sort_list.glsl"

vec3 sum = vec3(0.0);
vec3 visible = vec3(1.0);

void composite(Layer layer) {
    sum += visible * layer_color(layer);
    visible *= layer_factor(layer);
}

// Inserts `layer` into the sorted batch of `count`.
void insert(Layer layer, int count) {
    int place = count;
    while (place > 0 && nearer(layer, batch_layer(place - 1))) {
        set_batch_layer(place, batch_layer(place - 1));
        --place;
    }
    set_batch_layer(place, layer);
}

void resolve() {
    uint head = heads_first(pixel_index());
    int count = 0;
    int kept = 0;
    for (uint node = head; node != NONE && count <= BATCH; node = nodes_next(node)) {
        Layer layer = load_layer(node);
        if (count < BATCH && layer_seen(layer)) {
            insert(layer, kept++);
        }
        ++count;
    }
    if (count <= BATCH) {
        for (int i = 0; i < kept; ++i) {
            composite(batch_layer(i));
        }
    } else {
#if MSAA == 1
        head = sort_list(head);  // else done once a pixel, by sort_long.glsl
#endif
        for (uint node = head; node != NONE; node = nodes_next(node)) {
            Layer layer = load_layer(node);
            if (layer_seen(layer)) {
                composite(layer);
            }
        }
    }
    color = vec4(sum, 1.0);
    color_factor = vec4(visible, 0.0);
}
