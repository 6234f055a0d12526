// One shaded fragment: the argument of a method's gather().
struct Fragment {
    vec3 radiance;       // L, reflected and emitted, not premultiplied
    float coverage;      // alpha
    vec3 transmission;   // t
    float z;             // linear view distance, m
    float depth;         // window depth d in [0, 1]
    float inverse_depth; // 1 - d, precise at any distance: compare depths by this
    vec3 position;       // world space less whole kilometers, m; a list has pixels and view distance
    vec3 normal;         // unit, world space, on the viewer's side
    float incidence;     // cosine between normal and view
    float index;         // refractive index N of the solid that it bounds, 1 for none
    bool entering;       // whether the view ray enters that solid here
    float collimation;   // c
};

// Whether the fragment is before the opaque surface of this `inverse_depth`. In the plane of the
// opaque surface it is a decal: seen from its front, it is before that surface.
bool before_opaque(Fragment fragment, float opaque) {
#ifdef PLANES
    if (fragment.inverse_depth == opaque && opaque > 0.0) {
        return fragment.entering;
    }
#endif
    return fragment.inverse_depth > opaque;
}

// RGB transmittance of the layer: tau = 1 - alpha + alpha t.
vec3 transmittance(Fragment fragment) {
    return 1.0 - fragment.coverage * (1.0 - fragment.transmission);
}

// Net opacity: alpha (1 - mean t).
float net_opacity(Fragment fragment) {
    return fragment.coverage * (1.0 - dot(fragment.transmission, vec3(1.0 / 3.0)));
}

// Premultiplied radiance and net opacity, as scalar methods blend them.
vec4 premultiplied(Fragment fragment) {
    return vec4(fragment.coverage * fragment.radiance, net_opacity(fragment));
}
