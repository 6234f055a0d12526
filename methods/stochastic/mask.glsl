// Which of the 4 QUADS samples of this round a fragment takes: bit s for sample s.
#include "oitbench/random.glsl"
#if NOISE == NOISE_BLUE
#include "oitbench/blue_noise.glsl"

float rounding(uvec3 stream, uint word) {
    // No pixel has this place, so the hash is none of its words.
    return blue_noise(uvec3(NONE, NONE, uint(gl_PrimitiveID)) ^ stream, word);
}
#else
float rounding(uvec3 stream, uint word) {
    return unit_interval(word);
}
#endif

uint mask(Fragment fragment) {
    const uint count = uint(4 * QUADS);
    uvec3 stream = hash(uvec3(uint(SEED), iteration, frame_number));
    uvec3 words = hash(uvec3(gl_FragCoord.xy, uint(gl_PrimitiveID)) ^ stream);
    uint wanted = uint(net_opacity(fragment) * float(count) + rounding(stream, words.x));
    wanted = min(wanted, count);
    // Selection sampling (Knuth, volume 2, algorithm 3.4.2 S): sample s is taken with probability
    // wanted / left, by a product whose high word is a random integer below left.
    uint taken = 0u;
    uint state = words.y;
    for (uint s = 0u; s < count; ++s) {
        state = hash(state + words.z);
        uint high;
        uint low;
        umulExtended(state, count - s, high, low);
        if (high < wanted) {
            taken |= 1u << s;
            --wanted;
        }
    }
    return taken;
}
