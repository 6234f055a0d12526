// Random numbers that differ as much as possible between neighboring pixels, for passes that read
// `blue_noise`. The mask is shifted over the picture at random for each stream (Georgiev & Fajardo
// 2016, "Blue-noise dithered sampling"), so streams are independent and their mean is uniform.
#include "random.glsl"

// Uniform in [0, 1) at each pixel over all `stream`s. The mask gives the high half of 24 bits, and
// `word` the low one.
float blue_noise(uvec3 stream, uint word) {
    ivec2 shift = ivec2(hash(stream).xy >> 16u);
    float threshold = read_blue_noise(ivec2(gl_FragCoord.xy) + shift);
    return unit_interval(uint(threshold * 4096.0) << 20u | word >> 12u);
}
