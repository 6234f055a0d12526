// Composites a list front to back: a short one is sorted in local arrays, a long one in its links.
#include "node.glsl"

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

// Merges two sorted lists; returns the first node of the result.
uint merge(uint a, uint b) {
    Layer front = load_layer(a);
    Layer back = load_layer(b);
    uint head = NONE;
    uint tail = NONE;
    while (a != NONE && b != NONE) {
        bool second = nearer(back, front);
        uint taken = second ? b : a;
        if (tail == NONE) {
            head = taken;
        } else {
            set_nodes_next(tail, taken);
        }
        tail = taken;
        uint next = nodes_next(taken);
        if (next != NONE) {
            Layer layer = load_layer(next);
            if (second) {
                back = layer;
            } else {
                front = layer;
            }
        }
        a = second ? a : next;
        b = second ? next : b;
    }
    set_nodes_next(tail, a == NONE ? b : a);
    return head;
}

// Sorts a list by merging: run k has 2^k nodes, as the digits of a binary counter carry.
uint sort_list(uint node) {
    const int RUNS = 24;
    uint runs[RUNS];
    for (int k = 0; k < RUNS; ++k) {
        runs[k] = NONE;
    }
    while (node != NONE) {
        uint next = nodes_next(node);
        set_nodes_next(node, NONE);
        int k = 0;
        while (k < RUNS - 1 && runs[k] != NONE) {
            node = merge(runs[k], node);
            runs[k] = NONE;
            ++k;
        }
        runs[k] = node;
        node = next;
    }
    uint head = NONE;
    for (int k = 0; k < RUNS; ++k) {
        if (runs[k] != NONE) {
            head = head == NONE ? runs[k] : merge(runs[k], head);
        }
    }
    return head;
}

void resolve() {
    uint head = heads_first(pixel_index());
    int count = 0;
    for (uint node = head; node != NONE && count <= BATCH; node = nodes_next(node)) {
        if (count < BATCH) {
            insert(load_layer(node), count);
        }
        ++count;
    }
    if (count <= BATCH) {
        for (int i = 0; i < count; ++i) {
            composite(batch_layer(i));
        }
    } else {
        for (uint node = sort_list(head); node != NONE; node = nodes_next(node)) {
            composite(load_layer(node));
        }
    }
    color = vec4(sum, 1.0);
    color_factor = vec4(visible, 0.0);
}
