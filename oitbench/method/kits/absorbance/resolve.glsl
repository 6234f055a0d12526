// Finds a list's bounds, builds its curve, and composites the list against it.
#include "linked_lists/record.glsl"
#include "absorbance/base.glsl"

void resolve() {
    uint head = heads_first(pixel_index());
    vec2 bounds = vec2(-1e38);
    for (uint node = head; node != NONE; node = nodes_next(node)) {
        Layer layer = load_layer(node);
        if (any(lessThan(layer_factor(layer), vec3(1.0))) && layer_seen(layer)) {
            bounds = max(bounds, vec2(-layer_depth(layer), layer_depth(layer)));
        }
    }
    begin_curve();
    for (uint node = head; node != NONE; node = nodes_next(node)) {
        Layer layer = load_layer(node);
        if (layer_seen(layer)) {
            float u = relative_depth(layer_depth(layer), bounds);
            deposit(u, absorbance(served_factor(layer_factor(layer))));
        }
    }
    vec3 sum = vec3(0.0);
    for (uint node = head; node != NONE; node = nodes_next(node)) {
        Layer layer = load_layer(node);
        if (layer_seen(layer)) {
            sum += layer_color(layer) * visibility(relative_depth(layer_depth(layer), bounds));
        }
    }
    color = vec4(sum * served(), 1.0);
    color_factor = vec4(background_factor(visibility(1.0)), 0.0);
}
