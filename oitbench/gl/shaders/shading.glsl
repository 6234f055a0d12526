// Reflection by Lambert's law and a microfacet lobe (GGX, height-correlated Smith), or evenly to all
// sides; the same formulas are path traced (CONVENTIONS.md, "Reflection").
uniform sampler2D surface_materials;   // two texels a material, see oitbench/gl/surface_textures.py

struct Surface {
    vec3 albedo;
    float reflectance;   // F0; particles have none
    float roughness;
    float index;         // N, 1 where nothing is refracted
    float collimation;
    bool isotropic;
    bool binary;         // unfiltered coverage is 0 or 1
    bool receives;       // shadows
    bool mapped;         // whether maps of transparent surfaces hold it
    int lobe;            // number of its lobe, from 1; 0 for a smooth surface; -(number of the first
                         // step) where a texture gives the roughness
};

Surface surface_at(int material) {
    ivec2 at = ivec2(material % MATERIALS_ACROSS * 2, material / MATERIALS_ACROSS);
    vec4 first = texelFetch(surface_materials, at, 0);
    vec4 second = texelFetch(surface_materials, at + ivec2(1, 0), 0);
    int flags = int(second.w);
    bool isotropic = (flags & 1) != 0;
    return Surface(first.rgb, isotropic ? 0.0 : first.a, second.x, second.y, second.z, isotropic,
                   (flags & 2) != 0, (flags & 4) != 0, (flags & 8) != 0, flags >> 4);
}

// Schlick 1994; no lobe at all where nothing is reflected at normal incidence.
float fresnel(float reflectance, float cosine) {
    float away = 1.0 - clamp(cosine, 0.0, 1.0);
    float fifth = away * away * away * away * away;
    return reflectance > 0.0 ? reflectance + (1.0 - reflectance) * fifth : 0.0;
}

// The lobe of a beam from `l` times the cosine: Walter et al. 2007, with a least roughness, as a beam
// would be a point in a mirror. `l` and `v` lie on the side of `n`.
float microfacets(Surface surface, vec3 n, vec3 v, vec3 l) {
    float roughness = max(surface.roughness, LEAST_LOBE);
    float a = roughness * roughness;
    float nl = dot(n, l), nv = max(dot(n, v), 1e-4);
    if (surface.reflectance <= 0.0 || nl <= 0.0) {
        return 0.0;
    }
    vec3 h = normalize(l + v);
    float nh = clamp(dot(n, h), 0.0, 1.0);
    // (n.h)^2 (a^2 - 1) + 1 without the difference of nearly equal numbers: 1 - (n.h)^2 = |n x h|^2.
    vec3 across = cross(n, h);
    float spread = dot(across, across) + nh * nh * a * a;
    float density = a * a / max(PI * spread * spread, 1e-20);
    float masking = nl * sqrt(nv * nv * (1.0 - a * a) + a * a) +
                    nv * sqrt(nl * nl * (1.0 - a * a) + a * a);
    return density * 0.5 / max(masking, 1e-8) * fresnel(surface.reflectance, dot(h, v)) * nl;
}

// Surfaces that lie in the plane of a sheet are not in its shadow.
#ifdef PLANES
const int UNMAPPED = SHEET;
#else
const int UNMAPPED = APART;
#endif

#if defined(ENVIRONMENT) && defined(ROUGHNESS_TEXTURES)
// Light that the lobe of any roughness mirrors, between the steps of `rough_lobes`.
vec3 mirrored_between(Surface surface, vec3 n, vec3 v) {
    float at = surface.roughness * float(GRADES);
    int lower = min(int(at), GRADES - 1);
    int lobe = lower - surface.lobe;
    vec3 sharp = lower == 0 ? fresnel(surface.reflectance, dot(n, v)) *
                                  environment_radiance(reflect(-v, n))
                            : mirrored(lobe - 1, surface.reflectance, n, v);
    return mix(sharp, mirrored(lobe, surface.reflectance, n, v), at - float(lower));
}
#endif

// Radiance that leaves toward `v`; `openness` is the part of the environment that is not occluded, and
// `tau` the transmittance of the surface.
vec3 reflected(Surface surface, vec3 position, vec3 n, vec3 v, float openness, vec3 tau) {
    int kind = !surface.mapped ? UNMAPPED : surface.isotropic ? PARTICLE : SHEET;
    vec3 sum = vec3(0.0);
    for (int i = 0; i < BEAMS; ++i) {
        vec3 l = toward_light(i, position);
        float facing = max(dot(n, l), 0.0);
        vec3 factor = surface.isotropic ? surface.albedo / (4.0 * PI)
                                        : surface.albedo / PI * facing +
                                              microfacets(surface, n, v, l);
        if (any(greaterThan(factor, vec3(0.0)))) {
            vec3 side = surface.isotropic ? l : n;
            vec3 light = factor * irradiance(i, position);
#ifdef MEDIUM
            light *= passing_medium(i, position, DIMMING_STEPS);
#endif
            Receiver receiver = Receiver(position, side, kind, tau);
            sum += surface.receives ? light * beam_visibility(i, receiver) : light;
        }
    }
#ifdef ENVIRONMENT
    if (surface.isotropic) {
        return sum + surface.albedo * surroundings.rgb * openness;
    }
    sum += surface.albedo * surrounding_light(n) * openness;
#ifdef ROUGHNESS_TEXTURES
    if (surface.lobe < 0) {
        return sum + mirrored_between(surface, n, v);
    }
#endif
    if (surface.lobe > 0) {
        sum += mirrored(surface.lobe, surface.reflectance, n, v);
    } else if (surface.reflectance > 0.0) {
        sum += fresnel(surface.reflectance, dot(n, v)) * environment_radiance(reflect(-v, n));
    }
#endif
    return sum;
}
