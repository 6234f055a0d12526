// The weighted mean color fills the part of the pixel that the transmittance hides.
void resolve() {
    vec4 sum = read_accum();
    float covered = 1.0 - read_reveal();
    color = vec4(sum.rgb / max(sum.a, 1e-5) * covered, covered);
}
