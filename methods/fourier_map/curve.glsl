// A Fourier series of absorbance: the sum of all layers', then a cosine and a sine term for each of
// HARMONICS frequencies. Half the period's constant term is kept, as the total.
const int HARMONICS = TERMS / 2 - 1;
const float TURN = 6.283185307179586;

vec2 turned(vec2 a, vec2 b) { return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x); }

void deposit(float u, float absorbance) {
    vec2 base = vec2(cos(TURN * u), sin(TURN * u));
    vec2 wave = base;
    terms[0] += absorbance;
    for (int k = 1; k <= HARMONICS; ++k) {
        terms[2 * k - 1] += 2.0 * absorbance * wave.x;
        terms[2 * k] += 2.0 * absorbance * wave.y;
        wave = turned(wave, base);
    }
}

// The damping of harmonic k: Lanczos' sigma factor, or none.
float damping(int k) {
    float x = 0.5 * TURN * float(k) / float(HARMONICS + 1);
    return LANCZOS == 1 ? sin(x) / x : 1.0;
}

// The series integrated from 0 to u; ringing can take it below zero or beyond the total.
float absorbed(float u, float own) {
    vec2 base = vec2(cos(TURN * u), sin(TURN * u));
    vec2 wave = base;
    float sum = terms[0] * u;
    for (int k = 1; k <= HARMONICS; ++k) {
        vec2 term = vec2(terms[2 * k - 1] * wave.y, terms[2 * k] * (1.0 - wave.x));
        sum += damping(k) * (term.x + term.y) / (TURN * float(k));
        wave = turned(wave, base);
    }
    return u < 1.0 ? sum : terms[0];
}
