// Adds the light that reaches each plane of a texel to its sum over SAMPLES rays, and clears the
// optical depths for the next ray.
#ifdef GRAY
#define LIGHT float
#else
#define LIGHT vec3
#endif

LIGHT take_depth(uint i) {
#ifdef GRAY
    return float(exchange_slices_depth0(i, 0u)) / UNIT;
#else
    uvec3 depth = uvec3(exchange_slices_depth0(i, 0u), exchange_slices_depth1(i, 0u),
                        exchange_slices_depth2(i, 0u));
    return vec3(depth) / UNIT;
#endif
}

void add_light(uint i, LIGHT light) {
#ifdef GRAY
    set_slices_light0(i, slices_light0(i) + light);
#else
    set_slices_light0(i, slices_light0(i) + light.r);
    set_slices_light1(i, slices_light1(i) + light.g);
    set_slices_light2(i, slices_light2(i) + light.b);
#endif
}

void resolve() {
    uint stride = frame_size.x * frame_size.y;
    LIGHT light = LIGHT(1.0 / SAMPLES);
    for (uint k = 0u; k < uint(LIGHT_PLANES); ++k) {
        uint i = k * stride + pixel_index();
        add_light(i, light);
        LIGHT depth = take_depth(i);
        if (depth != LIGHT(0.0)) {
            light *= exp(-depth);
        }
    }
    gl_FragDepth = 0.0;   // a pass needs a target
}
