// Haar wavelets of absorbance A(x): the mean, then 2^j coefficients of each level j up to RANK.
// Depths are scaled by (TERMS - 1) / TERMS, so that the last of TERMS bins holds the total.
#define NEAR_MARGIN 1e-5
#define FAR_MARGIN 1e-2
const float SCALE = float(TERMS - 1) / float(TERMS);

void deposit(float u, float absorbance) {
    float x = u * SCALE;
    terms[0] += absorbance * (1.0 - x);
    for (int j = 0; j <= RANK; ++j) {
        float place = x * float(1 << j);
        int k = int(place);
        float before = place - float(k);
        terms[(1 << j) + k] -= absorbance * min(before, 1.0 - before);
    }
}

// The mean of A over bin `b`.
float mean_in_bin(int b) {
    float sum = terms[0];
    for (int j = 0; j <= RANK; ++j) {
        float value = terms[(1 << j) + (b >> (RANK + 1 - j))];
        sum += ((b >> (RANK - j)) & 1) == 0 ? value : -value;
    }
    return sum;
}

// Linear between the bin of `u` and the one before; nothing is absorbed before the first. A layer's
// bin holds a part of its own deposit, which must not hide it.
float absorbed(float u, float own) {
    if (terms[0] == 0.0) {
        return 0.0;
    }
    float mine = CORRECTION == 1 ? own : 0.0;
    if (u >= 1.0) {
        return mean_in_bin(TERMS - 1) - mine;
    }
    float place = u * SCALE * float(TERMS);
    int b = int(place);
    float inside = place - float(b);
    float before = b > 0 ? mean_in_bin(b - 1) : 0.0;
    return mix(before, mean_in_bin(b) - mine * (1.0 - inside), inside);
}
