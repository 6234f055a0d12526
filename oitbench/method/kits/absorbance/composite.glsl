// Adds the fragment, attenuated by the curve.
#include "absorbance/base.glsl"

void gather(Fragment fragment) {
    for (int i = 0; i < TERMS / 4; ++i) {
        set_terms(i, read_curve(i));
    }
    float visible = visibility(relative_depth(fragment.z, read_bounds()));
    color = vec4(fragment.coverage * fragment.radiance * visible * served(), 0.0);
}
