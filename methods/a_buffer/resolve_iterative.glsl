// Visibility of each layer as the product over all nearer ones (AT eq. 2), CHUNK layers a round:
// a software renderer limits how many steps the loops of one invocation may take.
#include "lists.glsl"

const uint CHUNK = 32u;

void resolve() {
    uint head = list_first();
    uint node = head;
    for (uint i = 0u; i < iteration * CHUNK && node != NONE; ++i) {
        node = list_next(node);
    }
    if (iteration > 0u && node == NONE) {
        discard;
    }
    vec3 sum = vec3(0.0);
    vec3 total = vec3(1.0);
    for (uint i = 0u; i < CHUNK && node != NONE; ++i) {
        Layer layer = load_layer(node);
        vec3 visible = vec3(1.0);
        total = vec3(1.0);
        bool seen_self = false;
        for (uint other = head; other != NONE; other = list_next(other)) {
            Layer front = load_layer(other);
            // Of equal layers the one earlier in the list counts as nearer; they are alike.
            bool equal = !nearer(front, layer) && !nearer(layer, front);
            bool hides = equal ? (other != node && !seen_self) : nearer(front, layer);
            seen_self = seen_self || other == node;
            vec3 factor = layer_seen(front) ? layer_factor(front) : vec3(1.0);
            visible *= hides ? factor : vec3(1.0);
            total *= factor;
        }
        sum += layer_seen(layer) ? visible * layer_color(layer) : vec3(0.0);
        node = list_next(node);
    }
    // The background is attenuated once; later rounds only add.
    color = vec4(sum, 1.0);
    color_factor = vec4(iteration == 0u ? total : vec3(1.0), 0.0);
}
