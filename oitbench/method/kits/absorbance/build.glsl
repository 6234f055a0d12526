// Adds the fragment's absorbance to the curve.
#include "absorbance/base.glsl"

void gather(Fragment fragment) {
    begin_curve();
    float u = relative_depth(fragment.z, read_bounds());
    deposit(u, absorbance(served_factor(transmittance(fragment))));
    for (int i = 0; i < TERMS / 4; ++i) {
        set_curve(i, four_terms(i));
    }
}
