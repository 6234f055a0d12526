// Sorts a counted list where it is.

// Moves `layer` down from `root` in the heap of `count` records, until no child is farther.
void sift(uint first, uint root, uint count, Layer layer) {
    for (uint child = 2u * root + 1u; child < count; child = 2u * root + 1u) {
        Layer farther = load_layer(first + child);
        if (child + 1u < count) {
            Layer other = load_layer(first + child + 1u);
            if (nearer(farther, other)) {
                farther = other;
                ++child;
            }
        }
        if (!nearer(layer, farther)) {
            break;
        }
        move_layer(first + root, farther);
        root = child;
    }
    move_layer(first + root, layer);
}

uint sort_list(uint first) {
    uint count = list_end - first;
    for (uint root = count / 2u; root > 0u; --root) {
        sift(first, root - 1u, count, load_layer(first + root - 1u));
    }
    for (uint last = count - 1u; last > 0u; --last) {
        Layer layer = load_layer(first + last);
        move_layer(first + last, load_layer(first));
        sift(first, 0u, last, layer);
    }
    return first;
}
