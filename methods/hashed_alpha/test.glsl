// Keeps the fragment where its opacity reaches the threshold; the depth test finds the nearest.
#include "oitbench/random.glsl"
#if NOISE == NOISE_BLUE
#include "oitbench/blue_noise.glsl"

float threshold(Fragment fragment) {
    uvec3 stream = hash(uvec3(gl_PrimitiveID, frame_number, 0u));
    uint word = hash(uvec3(gl_FragCoord.xy, 0u) ^ stream).x;
    return max(blue_noise(stream, word), 1e-6);
}
#else
#include "threshold.glsl"

float threshold(Fragment fragment) {
    return threshold(fragment.position);
}
#endif

void gather(Fragment fragment) {
    vec4 layer = premultiplied(fragment);
    if (layer.a < threshold(fragment) || !before_opaque(fragment, read_opaque_depth())) {
        discard;
    }
    color = vec4(layer.rgb / layer.a, 1.0);
}
