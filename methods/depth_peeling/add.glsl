// The peeled layer is seen through all layers before it.
void resolve() {
    sum = read_layer() * read_through();
}
