// The background is seen through all layers.
#include "absorbance/base.glsl"

void resolve() {
    for (int i = 0; i < TERMS / 4; ++i) {
        set_terms(i, read_curve(i));
    }
    color = vec4(background_factor(total_visibility()), 1.0);
}
