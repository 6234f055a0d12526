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
    vec4 sum = vec4(0.0);
    for (uint node = head; node != NONE; node = nodes_next(node)) {
        Layer layer = load_layer(node);
        if (layer_seen(layer)) {
            float own = absorbance(served_factor(layer_factor(layer)));
            float u = relative_depth(layer_depth(layer), bounds);
            sum += vec4(layer_color(layer), hidden_by(own)) * visibility(u, own);
        }
    }
#if NORMALIZED
    sum.rgb = filled(sum, hidden_by(absorbed(1.0, 0.0)));
#endif
    color = vec4(sum.rgb * served(), 1.0);
    color_factor = vec4(background_factor(total_visibility()), 0.0);
}
