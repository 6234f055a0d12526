// The light that a surface blocks, as a light sees it (McGuire & Mara 2017, equations 11 to 13).

// Factor on the blocked light for the refraction of a solid: less in the middle, where the caustic
// is, and more at the rim. s = 0 means no refraction, and avoids a power of zero.
float caustic_factor(float index, float cosine) {
#ifdef EFFECT_CAUSTICS
    float s = clamp(0.5 * (index - 1.0), 0.0, 1.0);
    if (s > 0.0) {
        float middle = pow(clamp(cosine, 1e-4, 1.0), 128.0 * s * s);
        return 1.0 + (1.0 - 2.0 * middle) * pow(s, 0.2);
    }
#endif
    return 1.0;
}

// Fraction of each channel that the surface blocks.
vec3 kept_back(Fragment fragment) {
    vec3 kept = fragment.coverage * (1.0 - fragment.transmission);
#ifdef GRAY
    // The mean, without rounding where all channels are equal.
    kept = vec3(kept.r + ((kept.g - kept.r) + (kept.b - kept.r)) / 3.0);
#endif
    return min(kept * caustic_factor(fragment.index, fragment.incidence), vec3(1.0));
}
