// The mean color of the layers, weighted by visibility, over the background.
#include "absorbance/base.glsl"

void resolve() {
    for (int i = 0; i < TERMS / 4; ++i) {
        set_terms(i, read_curve(i));
    }
    float hidden = hidden_by(absorbed(1.0, 0.0));
    vec3 light = filled(read_sum(), hidden);
#if CHANNELS == CHANNELS_RGB
    color = vec4(light, 1.0);
    color_factor = vec4(background_factor(1.0 - hidden), 0.0);
#else
    color = vec4(light, hidden);
#endif
}
