// Bends, blurs and tints the opaque picture and lays the mean layer over it (listing 3).
#include "model.glsl"
#include "blur.glsl"

vec3 self_modulation(vec3 beta) {
    float most = max(max(beta.r, beta.g), beta.b);
#if MODULATION == MODULATION_TVCG
    return 0.5 + max(beta, vec3(1e-3)) / max(2e-3, 2.0 * most);
#elif MODULATION == MODULATION_I3D
    return 0.5 + 0.5 * beta / max(0.01, most);
#else
    return vec3(1.0);
#endif
}

vec3 mean_layer() {
    vec4 sum = read_accum();
    return sum.rgb / max(sum.a, 1e-5);
}

vec2 offset_here() {
#ifdef EFFECT_REFRACTION
    vec2 pixels = read_delta() * UNIT;
#if OFFSET == OFFSET_NORMALIZED
    pixels /= max(read_bending(), 1e-5);
#endif
    return pixels;
#else
    return vec2(0.0);
#endif
}

void resolve() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 beta = read_beta().rgb;
    vec2 offset = offset_here();
    float blur = blur_at(pixel);
    vec3 behind = read_opaque_color().rgb;
    if (all(equal(beta, vec3(1.0))) && blur == 0.0 && offset == vec2(0.0)) {
        color = vec4(behind, 1.0);
        return;
    }
    // Of several samples a pixel, each bends and blurs the grid of its own samples.
    vec2 center = vec2(pixel) + 0.5 + offset;
    if (blur > 0.0) {
        behind = blurred(ivec2(floor(center)), blur);
    } else if (offset != vec2(0.0)) {
        behind = interpolated(center);
    }
    color = vec4(beta * behind + (1.0 - beta) * self_modulation(beta) * mean_layer(), 1.0);
}
