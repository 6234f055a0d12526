// The share of absorbance before a place, from trigonometric moments.
// Rounding hides smaller ratios of pivots: then the layers lie at fewer places than moments can tell.
const float LEAST_RATIO = 1e-7;

#if STORAGE == STORAGE_FLOAT
const float BIAS = COUNT == 4 ? 4e-7 : COUNT == 6 ? 8e-7 : 1.5e-6;
#else
const float BIAS = COUNT == 4 ? 4e-4 : COUNT == 6 ? 6.5e-4 : 8.5e-4;
#endif

float share_before(float x, float b[COUNT]) {
    // Moments are turned so that the place in question lies at one.
    float angle = angle_of(x);
    vec2 back = vec2(cos(angle), -sin(angle));
    vec2 power = back;
    vec2 moment[HALF];
    for (int k = 0; k < HALF; ++k) {
        moment[k] = (1.0 - BIAS) * times(vec2(b[2 * k], b[2 * k + 1]), power);
        power = times(power, back);
    }
    // Polynomials P_k that are orthogonal on the circle, by Szego's recurrence, with reversed R_k:
    // P_(k+1)(u) = u P_k - g_k R_k, R_(k+1) = R_k - conj(g_k) u P_k. The kernel
    // sum_k conj(P_k(1)) P_k(u) / pivot_k is a polynomial in u.
    vec2 g[HALF];
    float pivot[HALF + 1];
    vec2 poly[HALF + 1];
    vec2 kernel[HALF + 1];
    for (int j = 0; j <= HALF; ++j) {
        poly[j] = vec2(j == 0 ? 1.0 : 0.0, 0.0);
        kernel[j] = poly[j];
    }
    pivot[0] = 1.0;
    for (int k = 0; k < HALF; ++k) {
        vec2 sum = vec2(0.0);
        for (int j = 0; j <= k; ++j) {
            sum += times(poly[j], moment[j]);
        }
        sum /= pivot[k];
        float square = dot(sum, sum);
        float most = 1.0 - LEAST_RATIO;
        g[k] = square > most ? sum * sqrt(most / square) : sum;
        pivot[k + 1] = pivot[k] * max(1.0 - square, LEAST_RATIO);
        vec2 next[HALF + 1];
        vec2 at_one = vec2(0.0);
        for (int j = 0; j <= k + 1; ++j) {
            vec2 shifted = j > 0 ? poly[j - 1] : vec2(0.0);
            vec2 reversed = j <= k ? conjugate(poly[k - j]) : vec2(0.0);
            next[j] = shifted - times(g[k], reversed);
            at_one += next[j];
        }
        for (int j = 0; j <= k + 1; ++j) {
            poly[j] = next[j];
            kernel[j] += times(conjugate(at_one), next[j]) / pivot[k + 1];
        }
    }
    // u = (s + i) / (s - i) maps the circle to the line, and u = 1 to infinity.
    vec2 line[HALF + 1];
    vec2 lower[HALF + 1];
    for (int j = 0; j <= HALF; ++j) {
        line[j] = j == 0 ? kernel[HALF] : vec2(0.0);
        lower[j] = vec2(j == 0 ? 1.0 : 0.0, 0.0);
    }
    for (int k = HALF - 1; k >= 0; --k) {
        for (int j = HALF; j > 0; --j) {
            line[j] += times(line[j - 1], vec2(0.0, 1.0));
            lower[j] += times(lower[j - 1], vec2(0.0, -1.0));
        }
        for (int j = 0; j <= HALF; ++j) {
            line[j] += times(kernel[k], lower[j]);
        }
    }
    float real[HALF + 1];
    for (int j = 0; j <= HALF; ++j) {
        real[j] = line[j].x;
    }
    float[HALF] roots = real_roots(real);
    float here = 1.0 / real[0];
    float front = 0.0;
    float others = 0.0;
    for (int i = 0; i < HALF; ++i) {
        float turned = 2.0 * atan(1.0, roots[i]);
        vec2 u = vec2(cos(turned), sin(turned));
        vec2 p = vec2(1.0, 0.0);
        vec2 r = p;
        float inverse_weight = 1.0;
        for (int k = 0; k < HALF; ++k) {
            vec2 up = times(u, p);
            p = up - times(g[k], r);
            r -= times(conjugate(g[k]), up);
            inverse_weight += dot(p, p) / pivot[k + 1];
        }
        // Beyond a full turn a root lies before x; in the gap it does so by parts.
        float before = clamp((angle + turned - TURN + WRAP) / WRAP, 0.0, 1.0);
        others += 1.0 / inverse_weight;
        front += before / inverse_weight;
    }
    return OVERESTIMATION * here + (1.0 - here) * front / others;
}
