// The background times one minus the opacities, which is negative where they pass one. Not by
// blending, as GPUs would turn what exceeds half floats into infinity.
void resolve() {
    vec4 total = read_sum();
#if CLAMP
    total.a = min(total.a, 1.0);
#endif
    vec4 shown = total + (1.0 - total.a) * read_opaque_color();
#if PRECISION == PRECISION_HALF
    shown = clamp(shown, -65504.0, 65504.0);
#endif
    color = shown;
}
