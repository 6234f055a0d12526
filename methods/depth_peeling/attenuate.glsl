// The peeled layer attenuates all layers after it.
void resolve() {
    through = read_factor();
}
