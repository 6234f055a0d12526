// The sum of all frames so far, in linear light.
void resolve() {
    accumulated = read_color();
}
