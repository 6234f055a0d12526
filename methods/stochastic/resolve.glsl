// The weighted sum fills the part of the pixel that the transmittance hides.
void resolve() {
    vec4 gathered = read_sum();
#if CORRECTION == CORRECTION_NONE
    // A sample shows one layer, but for those of one depth and those that miss a pixel's center.
    color = gathered / max(gathered.a, 1.0);
#else
    float covered = 1.0 - read_total();
    // A half float's transmittance near one is too coarse to divide by.
    bool plain = CORRECTION == CORRECTION_DEPTH && covered < 1.0 / 64.0;
    float factor = plain || gathered.a <= 0.0 ? 1.0 : covered / gathered.a;
    color = vec4(gathered.rgb * factor, covered);
#endif
}
