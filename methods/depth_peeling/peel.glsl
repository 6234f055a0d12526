// Keeps the nearest fragment beyond the one peeled last; the depth test finds the nearest. A
// fragment without effect is no layer.
void gather(Fragment fragment) {
    bool between = fragment.inverse_depth < read_peeled() &&
                   before_opaque(fragment, read_opaque_depth());
    if (!between || fragment.coverage <= 0.0) {
        discard;
    }
    layer = vec4(fragment.coverage * fragment.radiance, 1.0);
    factor = vec4(transmittance(fragment), 1.0);
}
