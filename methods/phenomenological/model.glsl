// Constants of the model, and what both stages agree on about targets.
const float K0 = 0.25;              // m
const float K1 = 0.5;               // m
const float PAPER_REACH = 2.0;      // m
const float FARTHEST = 1e4;         // m; stands for a background at infinity
#if PRECISION == PRECISION_PAPER
const float UNIT = 63.0;            // pixels that one stands for in delta and in the root of D^2
const float LEAST = 1.0 / 255.0;    // what 8 bits can hold
#else
const float UNIT = 1.0;
const float LEAST = 0.0;
#endif

// What beta's target takes: what is removed, and the variance of the blur where it has a place.
#if !defined(EFFECT_DIFFUSION) && PRECISION == PRECISION_PAPER
vec3 modulation(vec3 removed, float variance) { return removed; }
#else
vec4 modulation(vec3 removed, float variance) { return vec4(removed, variance); }
#endif
