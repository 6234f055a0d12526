// Shades one fragment of a mesh and passes it to the method.
PLACED in vec2 v_uv;
INSIDE in vec3 v_radiance;
INSIDE in vec3 v_position;   // relative to the camera, m
flat in vec3 v_transmission;
flat in float v_coverage;
flat in float v_layer;
INSIDE in vec3 v_normal;
flat in float v_material;

#ifdef OF_SEVERAL
// One. Where values are not taken at the pixel's center, llvmpipe still divides them by its w, and
// errs by a common factor.
INSIDE in float v_one;
#define CORRECTED(value) ((value) / v_one)
#else
#define CORRECTED(value) (value)
#endif

#ifdef TEXTURED
#include "textures.glsl"
#endif
#ifdef VARIED
#include "variation.glsl"
#endif

#ifdef LIGHT_VIEW
#undef PLANES
#endif
#ifdef PLANES
#include "planes.glsl"
#endif
#ifdef TESTS_DEPTH
uniform sampler2D tested_depth;
#endif

#ifdef INTERIOR
// Filtered binary coverage of at least this is opaque.
const float WHOLE = 254.0 / 255.0;
#endif

#ifdef DETAILED
#include "detail.glsl"
#endif

void main() {
    Fragment fragment;
    fragment.radiance = CORRECTED(v_radiance) * radiance_gain;
    fragment.coverage = v_coverage;
    fragment.transmission = v_transmission;
#ifdef PLANES
    fragment.inverse_depth = inverse_depth_of_plane();
#else
    fragment.inverse_depth = gl_FragCoord.z;
#endif
    fragment.z = view_distance(fragment.inverse_depth);
    fragment.depth = window_depth(fragment.inverse_depth);
    vec3 position = CORRECTED(v_position);
    fragment.position = position + origin.xyz;
    fragment.normal = vec3(0.0);
    fragment.incidence = 1.0;
    fragment.index = 1.0;
    fragment.entering = gl_FrontFacing;
    fragment.collimation = 1.0;
#if defined(PLANES) && defined(OWN_DEPTH)
    gl_FragDepth = fragment.inverse_depth;
#endif
    // Outside any branch, and before any discard: derivatives need the whole quad.
#ifdef DETAILED
    vec3 toward = normalize(eye.xyz - eye.w * position);
    vec3 normal = facing_normal(position, toward);
#endif
#ifdef PER_SAMPLE
    vec2 uv = CORRECTED(v_uv);
#else
    vec2 uv = v_uv;
#endif
#ifdef VARIED
    look_up_variation(uv, int(v_material + 0.5));
#endif
    vec2 gradient = vec2(0.0);   // of the coverage, a pixel
#ifdef TEXTURED
    vec4 texel = filtered_texel(uv, int(max(v_layer, 0.0)));
    vec2 slope = vec2(dFdx(texel.a), dFdy(texel.a));
    if (v_layer >= 0.0) {
        gradient = v_coverage * slope;
        if (texel.a <= 0.0) {
            discard;
        }
        fragment.radiance *= texel.rgb / texel.a;
        fragment.coverage *= texel.a;
    }
#endif
#ifdef VARIED
    if (!vary(fragment, gradient)) {
        discard;
    }
#endif
#ifdef TESTS_DEPTH
    if (!before_opaque(fragment, texelFetch(tested_depth, ivec2(gl_FragCoord.xy), 0).r)) {
        discard;
    }
#endif
#ifdef INTERIOR
    if (fragment.coverage < WHOLE) {
        discard;
    }
#endif
#ifdef DETAILED
    add_reflection(fragment, position, normal, toward, gradient);
#endif
    DELIVER(fragment)
}
