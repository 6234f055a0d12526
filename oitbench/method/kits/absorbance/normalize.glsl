// Absorbance and visibility, and a composite whose weights sum to one.
#include "oitbench/hidden.glsl"

// Minus the logarithm of a transmittance; an opaque layer lets one part in 100,000 pass.
float absorbance(float factor) { return -log(max(factor, 1e-5)); }

// Visibility behind an absorbance. It never reaches zero, so that sums of weights do not either.
float visible_behind(float absorbed) { return exp(-clamp(absorbed, 0.0, 60.0)); }

// The weighted mean color fills the part of the pixel that all layers hide. `sum` holds alpha L and o,
// both times visibility. Where next to nothing hides, light adds up.
vec3 filled(vec4 sum, float hidden) {
    return sum.rgb * (hidden > 1e-4 && sum.a > 0.0 ? hidden / sum.a : 1.0);
}
