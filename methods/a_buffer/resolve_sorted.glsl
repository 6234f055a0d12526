// Composites a list front to back, BATCH nearest layers at a time.
#include "node.glsl"

// Inserts `layer` into the sorted batch of `count`, whose last one gives way when it is full.
void insert(Layer layer, int count) {
    int place = min(count, BATCH - 1);
    while (place > 0 && nearer(layer, batch_layer(place - 1))) {
        set_batch_layer(place, batch_layer(place - 1));
        --place;
    }
    set_batch_layer(place, layer);
}

void resolve() {
    uint head = heads_first(pixel_index());
    vec3 sum = vec3(0.0);
    vec3 visible = vec3(1.0);
    Layer last = batch_layer(0);
    uint copies = 0u;   // how many layers that equal `last` have been composited
    bool first = true;
    bool more = true;
    while (more) {
        // The BATCH nearest of all that have not been composited yet.
        int count = 0;
        uint skip = copies;
        more = false;
        for (uint node = head; node != NONE; node = nodes_next(node)) {
            Layer layer = load_layer(node);
            bool done = !first && !nearer(last, layer);
            if (done && !nearer(layer, last)) {
                done = skip > 0u;
                skip -= done ? 1u : 0u;
            }
            if (!done) {
                more = more || count == BATCH;
                if (count < BATCH || nearer(layer, batch_layer(BATCH - 1))) {
                    insert(layer, count);
                }
                count = min(count + 1, BATCH);
            }
        }
        uint equal = 0u;
        Layer end = batch_layer(max(count - 1, 0));
        for (int i = 0; i < count; ++i) {
            Layer layer = batch_layer(i);
            sum += visible * layer_color(layer);
            visible *= layer_factor(layer);
            equal += nearer(layer, end) ? 0u : 1u;
        }
        copies = (!first && !nearer(last, end) ? copies : 0u) + equal;
        last = end;
        first = false;
    }
    color = vec4(sum, 1.0);
    color_factor = vec4(visible, 0.0);
}
