// A curve of absorbance over relative depth in one pixel: `curve.glsl` is the method's.
#include "curves/channels.glsl"
#include "absorbance/normalize.glsl"

float terms[TERMS];

#include "curve.glsl"

void begin_curve() {
    for (int i = 0; i < TERMS; ++i) {
        terms[i] = 0.0;
    }
}

// Margins before the nearest and behind the farthest layer, meters; a curve can define others.
#ifndef NEAR_MARGIN
#define NEAR_MARGIN 0.0
#define FAR_MARGIN 0.0
#endif

// Relative depth of `z` in [0, 1], between bounds (-nearest, farthest) of absorbing layers. Layers at
// the same distance lie at the front, where nothing hides them, and layers behind them at 1.
float relative_depth(float z, vec2 bounds) {
    float range = bounds.x + bounds.y + (NEAR_MARGIN + FAR_MARGIN);
    return clamp((z + bounds.x + NEAR_MARGIN) / max(range, 1e-6), 0.0, 1.0);
}

// Visibility of a layer at `u` that itself has the absorbance `own`.
float visibility(float u, float own) { return visible_behind(absorbed(u, own)); }

// Visibility of the background.
float total_visibility() { return visible_behind(absorbed(1.0, 0.0)); }

void set_terms(int i, vec4 values) {
    for (int k = 0; k < 4; ++k) {
        terms[4 * i + k] = values[k];
    }
}

vec4 four_terms(int i) {
    return vec4(terms[4 * i], terms[4 * i + 1], terms[4 * i + 2],
                terms[4 * i + 3]);
}
