// Encodings of targets that both stages share.
const float FARTHEST = 1e4;         // m; the distance of a background at infinity
#if PRECISION == PRECISION_PAPER
const float UNIT = 63.0;            // pixels per unit of delta and of the root of D^2
const float LEAST = 1.0 / 255.0;    // the step of 8 bits
#else
const float UNIT = 1.0;
const float LEAST = 0.0;
#endif

// The value of beta's target: the removed light, and the variance of the blur if it is stored.
#if !defined(EFFECT_DIFFUSION) && PRECISION == PRECISION_PAPER
vec3 modulation(vec3 removed, float variance) { return removed; }
#else
vec4 modulation(vec3 removed, float variance) { return vec4(removed, variance); }
#endif
