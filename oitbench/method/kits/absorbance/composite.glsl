// Adds the fragment, attenuated by the curve.
#include "absorbance/base.glsl"

void gather(Fragment fragment) {
    for (int i = 0; i < TERMS / 4; ++i) {
        set_terms(i, read_curve(i));
    }
    float own = absorbance(served_factor(transmittance(fragment)));
    float visible = visibility(relative_depth(fragment.z, read_bounds()), own);
    vec3 light = fragment.coverage * fragment.radiance * served();
#if NORMALIZED
    sum = vec4(light, hidden_by(own)) * visible;
#else
    color = vec4(light * visible, 0.0);
#endif
}
