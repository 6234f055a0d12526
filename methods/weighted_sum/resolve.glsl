// Blending multiplies the background by 1 - alpha, which is negative where opacities pass one.
void resolve() {
    color = read_sum();
#if CLAMP
    color.a = min(color.a, 1.0);
#endif
}
