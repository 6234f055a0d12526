// Gives each pixel as many records as it has fragments; none if memory has run out.
void resolve() {
    uint count = read_stored();
    uint first = allocate_nodes(count);
    heads = first != NONE ? uvec2(first, count) : uvec2(0u);
}
