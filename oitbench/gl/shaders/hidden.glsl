// The part of the light that an absorbance hides: 1 - exp(-a), by its series where the rounding of exp
// would show. GPUs bias exp by 2e-7, which adds up over the thin slices of a march.
float hidden_by(float absorbance) {
    float a = max(absorbance, 0.0);
    return a < 0.0625 ? a * (1.0 - a * (0.5 - a * (1.0 / 6.0 - a * (1.0 / 24.0 - a / 120.0))))
                      : 1.0 - exp(-a);
}
