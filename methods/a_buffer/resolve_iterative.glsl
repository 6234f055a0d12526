// Visibility of each layer as the product over all nearer ones (AT eq. 2).
#include "node.glsl"

void resolve() {
    uint head = heads_first(pixel_index());
    vec3 sum = vec3(0.0);
    vec3 total = vec3(1.0);
    for (uint node = head; node != NONE; node = nodes_next(node)) {
        Layer layer = load_layer(node);
        vec3 visible = vec3(1.0);
        bool seen_self = false;
        for (uint other = head; other != NONE; other = nodes_next(other)) {
            Layer front = load_layer(other);
            // Of equal layers the one earlier in the list counts as nearer; they are alike.
            bool equal = !nearer(front, layer) && !nearer(layer, front);
            bool hides = equal ? (other != node && !seen_self) : nearer(front, layer);
            seen_self = seen_self || other == node;
            visible *= hides ? layer_factor(front) : vec3(1.0);
        }
        sum += visible * layer_color(layer);
        total *= layer_factor(layer);
    }
    color = vec4(sum, 1.0);
    color_factor = vec4(total, 0.0);
}
