// The share of absorbance before a place, from power moments.
// Rounding hides smaller pivots: then the layers lie at fewer places than the moments could tell.
const float LEAST_PIVOT = 1e-7;

#if STORAGE == STORAGE_FLOAT
#if COUNT == 4
const float BIAS = 5e-7;
const float[4] NEUTRAL = float[4](0.0, 0.375, 0.0, 0.375);
#elif COUNT == 6
const float BIAS = 5e-6;
const float[6] NEUTRAL = float[6](0.0, 0.48, 0.0, 0.451, 0.0, 0.45);
#else
const float BIAS = 5e-5;
const float[8] NEUTRAL = float[8](0.0, 0.75, 0.0, 0.67666667, 0.0, 0.63, 0.0, 0.60030303);
#endif
#else
#if COUNT == 4
const float BIAS = 6e-5;
const float[4] NEUTRAL = float[4](0.0, 0.628, 0.0, 0.628);
#elif COUNT == 6
const float BIAS = 6e-4;
const float[6] NEUTRAL = float[6](0.0, 0.5566, 0.0, 0.489, 0.0, 0.47869382);
#else
const float BIAS = 2.5e-3;
const float[8] NEUTRAL = float[8](0.0, 0.42474916387959866, 0.0, 0.22407802675585284, 0.0,
                                  0.15369230769230768, 0.0, 0.12900440529089119);
#endif
#endif

float share_before(float x, float b[COUNT]) {
    // Polynomials p_k that are orthogonal under the moments, by Chebyshev's algorithm:
    // p_(k+1)(y) = (y - center_k) p_k(y) - factor_k p_(k-1)(y), with the squared norms pivot_k.
    float pivot[HALF + 1];
    float center[HALF];
    float factor[HALF];
    float older[COUNT + 1];
    float old[COUNT + 1];
    old[0] = 1.0;
    for (int l = 1; l <= COUNT; ++l) {
        older[l] = 0.0;
        old[l] = mix(b[l - 1], NEUTRAL[l - 1], BIAS);
    }
    pivot[0] = 1.0;
    factor[0] = 0.0;
    center[0] = clamp(old[1], -1.0, 1.0);
    float centers = center[0];
    for (int k = 1; k <= HALF; ++k) {
        float new[COUNT + 1];
        for (int l = k; l <= COUNT - k; ++l) {
            new[l] = old[l + 1] - center[k - 1] * old[l] - factor[k - 1] * older[l];
        }
        pivot[k] = max(new[k], LEAST_PIVOT);
        if (k < HALF) {
            center[k] = clamp(new[k + 1] / pivot[k] - centers, -1.0, 1.0);
            factor[k] = pivot[k] / pivot[k - 1];
            centers += center[k];
        }
        for (int l = k; l <= COUNT - k; ++l) {
            older[l] = old[l];
            old[l] = new[l];
        }
    }
    // The kernel sum_k p_k(x) p_k(x + t) / pivot_k as a polynomial in t.
    float kernel[HALF + 1];
    float before[HALF + 1];
    float now[HALF + 1];
    for (int j = 0; j <= HALF; ++j) {
        before[j] = 0.0;
        now[j] = j == 0 ? 1.0 : 0.0;
        kernel[j] = now[j];
    }
    for (int k = 1; k <= HALF; ++k) {
        for (int j = HALF; j >= 0; --j) {
            float next = (x - center[k - 1]) * now[j] - factor[k - 1] * before[j];
            before[j] = now[j];
            now[j] = next + (j > 0 ? now[j - 1] : 0.0);
        }
        for (int j = 0; j <= HALF; ++j) {
            kernel[j] += now[0] * now[j] / pivot[k];
        }
    }
    // With x itself, its roots are the places of the layers that hide most at x; t = 1 / s.
    float[HALF] roots = real_roots(kernel);
    float here = 1.0 / kernel[0];
    float front = 0.0;
    float others = 0.0;
    for (int i = 0; i < HALF; ++i) {
        float y = x + 1.0 / (roots[i] < 0.0 ? min(roots[i], -1e-2) : max(roots[i], 1e-2));
        float p0 = 0.0;
        float p1 = 1.0;
        float inverse_weight = 1.0;
        for (int k = 1; k <= HALF; ++k) {
            float p2 = (y - center[k - 1]) * p1 - factor[k - 1] * p0;
            inverse_weight += p2 * p2 / pivot[k];
            p0 = p1;
            p1 = p2;
        }
        others += 1.0 / inverse_weight;
        front += roots[i] < 0.0 ? 1.0 / inverse_weight : 0.0;
    }
    return OVERESTIMATION * here + (1.0 - here) * front / others;
}
