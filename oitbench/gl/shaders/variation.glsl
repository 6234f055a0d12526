// What varies over a surface beside emission and coverage, and what is not drawn of it. Only scenes that
// have some compile this; the table: oitbench/gl/surface_textures.py.
#ifdef VERTEX_FACTORS
INSIDE in vec3 v_albedo;    // factors
INSIDE in vec3 v_passing;
INSIDE in float v_part;
// Interpolation between equal vertices turns 1 into 0.9999999.
const float ALMOST_ONE = 1.0 - 1e-6;
#endif

struct Variation {
    vec3 albedo;         // factors
    vec3 transmission;
    float coverage;
    float roughness;
    float threshold;     // least coverage that is drawn, 0 for no cutoff
    bool drawn;          // whether this side is
};
Variation varied;

#if defined(ALBEDO_TEXTURES) || defined(TRANSMISSION_TEXTURES) || defined(ROUGHNESS_TEXTURES)
#define VARIATION_TABLE 1

vec3 textured_factor(vec2 uv, float number) {
    vec4 texel = filtered_texel(uv, int(max(number, 0.0)));
    return number < 0.0 ? vec3(1.0) : texel.rgb / max(texel.a, 1e-30);
}
#endif
#if defined(CUTOFF) || defined(CULLED)
#define VARIATION_TABLE 1
#endif

#ifdef VARIATION_TABLE
uniform sampler2D surface_variation;   // two texels a material
#endif

// Needs derivatives: call it outside any branch.
void look_up_variation(vec2 uv, int material) {
    varied = Variation(vec3(1.0), vec3(1.0), 1.0, 1.0, 0.0, true);
#ifdef VARIATION_TABLE
    ivec2 at = ivec2(material % MATERIALS_ACROSS * 2, material / MATERIALS_ACROSS);
    vec4 stored = texelFetch(surface_variation, at, 0);
    varied.threshold = stored.w;
#ifdef CULLED
    bool culled = texelFetch(surface_variation, at + ivec2(1, 0), 0).x > 0.0;
    varied.drawn = gl_FrontFacing || !culled;
#endif
#ifdef ALBEDO_TEXTURES
    varied.albedo = textured_factor(uv, stored.x);
#endif
#ifdef TRANSMISSION_TEXTURES
    varied.transmission = textured_factor(uv, stored.y);
#endif
#ifdef ROUGHNESS_TEXTURES
    varied.roughness = textured_factor(uv, stored.z).r;
#endif
#endif
#ifdef VERTEX_FACTORS
    vec3 albedo = CORRECTED(v_albedo), passing = CORRECTED(v_passing);
    float part = CORRECTED(v_part);
    varied.albedo *= mix(albedo, vec3(1.0), greaterThan(albedo, vec3(ALMOST_ONE)));
    varied.transmission *= mix(passing, vec3(1.0), greaterThan(passing, vec3(ALMOST_ONE)));
    varied.coverage = part > ALMOST_ONE ? 1.0 : part;
#endif
}

// Whether the fragment is drawn at all.
bool vary(inout Fragment fragment, inout vec2 gradient) {
    fragment.transmission *= varied.transmission;
    fragment.coverage *= varied.coverage;
    gradient *= varied.coverage;
    if (varied.threshold > 0.0) {
        fragment.coverage = fragment.coverage >= varied.threshold ? 1.0 : 0.0;
        gradient = vec2(0.0);
    }
    return varied.drawn && fragment.coverage > 0.0;
}
