// Keeps the nearest fragment beyond the one peeled last; the depth test finds the nearest.
void gather(Fragment fragment) {
    if (fragment.depth <= read_peeled() || fragment.depth >= read_opaque_depth()) {
        discard;
    }
    layer = vec4(fragment.coverage * fragment.radiance, 1.0);
    factor = vec4(transmittance(fragment), 1.0);
}
