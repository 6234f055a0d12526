// The mean color of the layers, weighted by visibility, over the background.
#include "absorbance/normalize.glsl"

void resolve() {
    float hidden = hidden_by(read_total());
    color = vec4(filled(read_sum(), hidden), hidden);
}
