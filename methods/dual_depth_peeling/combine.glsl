// The front layers over the back layers over the background; each channel has its own opacity if
// transmission is colored.
#include "curves.glsl"

void resolve() {
    vec3 sum, factor;
    for (int i = 0; i < 3; ++i) {
        vec4 near = read_front(i % CURVES);
        vec4 far = read_back(i % CURVES);
        sum[i] = near[i] + (1.0 - near.a) * far[i];
        factor[i] = (1.0 - near.a) * (1.0 - far.a);
    }
    color = vec4(sum, 1.0);
    color_factor = vec4(factor, 0.0);
}
