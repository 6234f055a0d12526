// How open a fragment is to the environment. Opaque surfaces, with the interiors of binary coverage,
// are looked up; a partly covering edge of binary coverage infers it from the interior beside it
// (McGuire & Mara 2017, section 6 and listing 2); other transparent surfaces are open.
#define OCCLUSION 1

uniform sampler2D openness_texture;
uniform sampler2D occluders_texture;

const float SOFTNESS = 0.01;     // m of difference in distance that halve a sample's weight
const float NO_GRADIENT = 1e-4;  // coverage a pixel
const float NO_WEIGHT = 1e-4;    // so little that the listing's 0.01 would darken: nothing is known

// Openness `offset` pixels away times its weight for a fragment at distance `z`, and the weight.
vec2 weighted_openness(vec2 offset, float z) {
    ivec2 last = textureSize(openness_texture, 0) - 1;
    ivec2 at = clamp(ivec2(gl_FragCoord.xy + offset), ivec2(0), last);
    float there = view_distance(texelFetch(occluders_texture, at, 0).r);
    float weight = SOFTNESS / (SOFTNESS + abs(z - there));
    return vec2(texelFetch(openness_texture, at, 0).r * weight, weight);
}

// Up the gradient of coverage there is the interior; without one, all around.
float inferred_openness(vec2 gradient, float z) {
    float steepness = length(gradient);
    vec2 sum = vec2(0.0);
    if (steepness >= NO_GRADIENT) {
        for (int k = 0; k < 12; ++k) {
            sum += weighted_openness(3.0 * float(k) * gradient / steepness, z);
        }
    } else {
        for (int y = -3; y <= 3; ++y) {
            float shift = float(abs(y) & 1) - 0.5;
            for (int x = -3; x <= 3; ++x) {
                sum += weighted_openness(2.0 * vec2(float(x) + shift, float(y)), z);
            }
        }
    }
    return sum.y < NO_WEIGHT ? 1.0 : clamp(sum.x / sum.y, 0.0, 1.0);
}

float openness_of(Surface surface, float coverage, vec2 gradient, float z) {
#ifdef OPAQUE
    return texelFetch(openness_texture, ivec2(gl_FragCoord.xy), 0).r;
#else
#ifdef EFFECT_INFERRED_AO
    if (surface.binary && coverage > 0.0 && coverage < 1.0) {
        return inferred_openness(gradient, z);
    }
#endif
    return 1.0;
#endif
}
