// Each slab's mean color over the next slab's, over the background.
#include "oitbench/hidden.glsl"

float part(float values, int i) { return values; }
float part(vec2 values, int i) { return values[i]; }
float part(vec4 values, int i) { return values[i]; }

void add(vec4 slab, float absorbance) {
    float covered = hidden_by(absorbance);
    // Where next to nothing hides, light adds up.
    vec3 light = slab.rgb * (slab.a > 1e-4 ? covered / slab.a : 1.0);
    color += (1.0 - color.a) * vec4(light, covered);
}

void resolve() {
    color = vec4(0.0);
    for (int i = 0; i < HELD; ++i) {
        add(read_near(i), part(read_near_absorbance(), i));
    }
#if LAYERS > HELD
    for (int i = 0; i < HELD; ++i) {
        add(read_far(i), part(read_far_absorbance(), i));
    }
#endif
}
