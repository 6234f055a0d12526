// Roots of c[0] s^n + c[1] s^(n-1) + ... + c[n] with n = HALF, all of which are real; c[0] > 0.

// The outermost root on the side of the mean, by Laguerre's method, from the bound of Samuelson.
float outermost(float c[HALF + 1], int degree) {
    float n = float(degree);
    float spread = sqrt(max(c[1] * c[1] - 2.0 * n / (n - 1.0) * c[2], 0.0));
    float s = (-c[1] + (c[1] > 0.0 ? -1.0 : 1.0) * (n - 1.0) * spread) / n;
    for (int step = 0; step < 6; ++step) {
        float value = 1.0;
        float slope = 0.0;
        float bend = 0.0;
        for (int k = 1; k <= degree; ++k) {
            bend = bend * s + slope;
            slope = slope * s + value;
            value = value * s + c[k];
        }
        float inner = (n - 1.0) * ((n - 1.0) * slope * slope - 2.0 * n * value * bend);
        float below = slope + (slope < 0.0 ? -1.0 : 1.0) * sqrt(max(inner, 0.0));
        s -= abs(below) > 1e-30 ? n * value / below : 0.0;
    }
    return s;
}

float[HALF] real_roots(float c[HALF + 1]) {
    float found[HALF];
    for (int k = HALF; k >= 0; --k) {
        c[k] /= c[0];
    }
    for (int degree = HALF; degree > 2; --degree) {
        float s = outermost(c, degree);
        s = abs(s) < 1e-12 ? 1e-12 : s;
        found[degree - 1] = s;
        // Division by s' - s from the constant term on, which is stable for a large root.
        float next = -c[degree] / s;
        for (int k = degree - 1; k > 0; --k) {
            float kept = c[k];
            c[k] = next;
            next = (next - kept) / s;
        }
    }
    float larger = sqrt(max(0.25 * c[1] * c[1] - c[2], 0.0));
    larger = -0.5 * c[1] + (c[1] > 0.0 ? -larger : larger);
    found[0] = larger;
    found[1] = larger == 0.0 ? 0.0 : c[2] / larger;
    return found;
}
