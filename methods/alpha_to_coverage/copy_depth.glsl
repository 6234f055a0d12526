// Surfaces behind the opaque picture must not cover its samples.
void resolve() {
    gl_FragDepth = read_opaque_depth();
}
