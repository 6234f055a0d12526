// Shares the fragment between the two slabs around its depth; this pass fills HELD of them.
#include "oitbench/hidden.glsl"
#if BLOCK == 0
#define SET_SLAB set_near
#define ABSORBANCE near_absorbance
#else
#define SET_SLAB set_far
#define ABSORBANCE far_absorbance
#endif

// Place among the middles of slabs 0 to LAYERS - 1; bounds are (-nearest, farthest).
float place_of(float z, vec2 bounds) {
    float nearest = -bounds.x;
    if (bounds.y <= nearest) {
        return 0.0;
    }
    float t = log(z / nearest) / max(log(bounds.y / nearest), 1e-6);
    return clamp(float(LAYERS) * t - 0.5, 0.0, float(LAYERS - 1));
}

void gather(Fragment fragment) {
    vec4 layer = premultiplied(fragment);
    float absorbed = -log(max(1.0 - layer.a, 5.9604645e-8));
    float place = place_of(fragment.z, read_bounds());
    vec4 absorbances = vec4(0.0);
    for (int i = 0; i < HELD; ++i) {
        float share = max(1.0 - abs(place - float(BLOCK * HELD + i)), 0.0);
        absorbances[i] = share * absorbed;
        // The whole opacity of a layer in one slab, without the rounding of its logarithm.
        float opacity = share < 1.0 ? hidden_by(absorbances[i]) : layer.a;
        // Light of layers that hide nothing is shared, too.
        float fraction = layer.a > 1e-4 ? opacity / layer.a : share;
        SET_SLAB(i, vec4(layer.rgb * fraction, opacity));
    }
#if HELD == 1
    ABSORBANCE = absorbances.x;
#elif HELD == 2
    ABSORBANCE = absorbances.xy;
#else
    ABSORBANCE = absorbances;
#endif
}
