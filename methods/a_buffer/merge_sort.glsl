// Sorts a linked list in its links.

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
