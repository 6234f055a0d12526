// Builds the curve from a list, then composites the list against it (AT section 4.1).
#include "linked_lists/record.glsl"
#include "curve.glsl"

void resolve() {
    uint head = heads_first(pixel_index());
    begin_curve();
    for (uint node = head; node != NONE; node = nodes_next(node)) {
        Layer layer = load_layer(node);
        float factor = served_factor(layer_factor(layer));
        if (factor < 1.0 && layer_seen(layer)) {
            insert(layer_depth(layer), factor);
        }
    }
    vec3 sum = vec3(0.0);
    for (uint node = head; node != NONE; node = nodes_next(node)) {
        Layer layer = load_layer(node);
        if (layer_seen(layer)) {
            sum += layer_color(layer) * visibility(layer_depth(layer));
        }
    }
    color = vec4(sum * served(), 1.0);
    color_factor = vec4(background_factor(total()), 0.0);
}
