// Adds the fragment and its weight, both attenuated by the absorbance in front of it.
#include "absorbance/normalize.glsl"
#include "place.glsl"
#include "roots.glsl"
#if BASIS == BASIS_POWER
#include "power.glsl"
#else
#include "trigonometric.glsl"
#endif
#if STORAGE == STORAGE_UNORM16
#include "quantize.glsl"
#endif

float[COUNT] normalized_moments(float absorbed) {
    float found[COUNT];
#if STORAGE == STORAGE_UNORM16
    for (int i = 0; i < HALF; ++i) {
        vec2 pair = unpackUnorm2x16(read_words(i));
        found[2 * i] = pair.x;
        found[2 * i + 1] = pair.y;
    }
    return from_unit(found);
#else
    for (int i = 0; i < COUNT; ++i) {
        found[i] = read_moments(i / WIDTH)[i % WIDTH] / absorbed;
    }
    return found;
#endif
}

void gather(Fragment fragment) {
    float absorbed = read_total();
    float own = absorbance(1.0 - net_opacity(fragment));
    float share = 0.0;
    if (absorbed > 0.0) {
        share = share_before(place_of(fragment), normalized_moments(absorbed));
    }
    vec4 layer = vec4(fragment.coverage * fragment.radiance, hidden_by(own));
    sum = layer * visible_behind(absorbed * share);
}
