// A curve of absorbance over relative depth in one pixel: `curve.glsl` is the method's.
#include "curves/channels.glsl"

float terms[TERMS];

#include "curve.glsl"

void begin_curve() {
    for (int i = 0; i < TERMS; ++i) {
        terms[i] = 0.0;
    }
}

// Minus the logarithm of a transmittance; an opaque layer lets one part in 100,000 pass.
float absorbance(float factor) { return -log(max(factor, 1e-5)); }

// Relative depth of `z` in [0, 1], between bounds (-nearest, farthest) of absorbing layers. Layers at
// the same distance lie at 0, where nothing hides them, and layers behind them at 1.
float relative_depth(float z, vec2 bounds) {
    return clamp((z + bounds.x) / max(bounds.x + bounds.y, 1e-6), 0.0, 1.0);
}

float visibility(float u) { return exp(-max(absorbed(u), 0.0)); }

void set_terms(int i, vec4 values) {
    for (int k = 0; k < 4; ++k) {
        terms[4 * i + k] = values[k];
    }
}

vec4 four_terms(int i) {
    return vec4(terms[4 * i], terms[4 * i + 1], terms[4 * i + 2],
                terms[4 * i + 3]);
}
