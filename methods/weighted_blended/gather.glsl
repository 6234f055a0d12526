// McGuire & Bavoil 2013, equations 7 to 10, or fitted; z in meters, d window depth.
float weight(float z, float d) {
#if WEIGHT == WEIGHT_7
    return clamp(10.0 / (1e-5 + pow(z / 5.0, 2.0) + pow(z / 200.0, 6.0)), 1e-2, 3e3);
#elif WEIGHT == WEIGHT_8
    return clamp(10.0 / (1e-5 + pow(z / 10.0, 3.0) + pow(z / 200.0, 6.0)), 1e-2, 3e3);
#elif WEIGHT == WEIGHT_9
    return clamp(0.03 / (1e-5 + pow(z / 200.0, 4.0)), 1e-2, 3e3);
#elif WEIGHT == WEIGHT_FITTED
    float falloff = pow(z / float(NEAR_RANGE), float(NEAR_POWER));
    return clamp(10.0 / (1e-5 + falloff + pow(z / float(FAR_RANGE), float(FAR_POWER))), 1e-2, 3e3);
#else
    return max(1e-2, 3e3 * pow(1.0 - d, 3.0));
#endif
}

void gather(Fragment fragment) {
    vec4 layer = premultiplied(fragment);
    accum = layer * (layer.a * weight(fragment.z, fragment.depth));
    reveal = layer.a;
}
