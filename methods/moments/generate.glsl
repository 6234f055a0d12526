// Adds the fragment's absorbance and its moments to those of the pixel.
#include "absorbance/normalize.glsl"
#include "place.glsl"
#if STORAGE == STORAGE_UNORM16
#include "quantize.glsl"
#endif

void gather(Fragment fragment) {
    float own = absorbance(1.0 - net_opacity(fragment));
    float[COUNT] added = moments_at(place_of(fragment));
#if STORAGE == STORAGE_UNORM16
    if (own <= 0.0) {
        return;
    }
    // Normalized moments are a mean, weighted by absorbance.
    float share = own / (total + own);
    float[COUNT] mean = to_unit(added);
    for (int i = 0; i < HALF; ++i) {
        vec2 old = unpackUnorm2x16(get_words(i));
        vec2 new = vec2(mean[2 * i], mean[2 * i + 1]);
        set_words(i, packUnorm2x16(mix(old, new, share)));
    }
    total += own;
#else
    total = own;
    for (int i = 0; i < COUNT / WIDTH; ++i) {
#if WIDTH == 2
        set_moments(i, own * vec2(added[2 * i], added[2 * i + 1]));
#else
        set_moments(i, own * vec4(added[4 * i], added[4 * i + 1], added[4 * i + 2], added[4 * i + 3]));
#endif
    }
#endif
}
