// The opaque picture: interpolated between texels, and blurred around a pixel.
const int STRIDE = 2;          // pixels between taps
const float LISTING = 16.0;    // largest blur of listing 3, pixels

// Radius of the kernel in standard deviations. A uniform disk of radius 2 has the deviation 1 along
// each axis; that of listing 3 has radius 1, and so half the deviation of equation 7.
#if KERNEL == KERNEL_GAUSSIAN
const float CUT = 3.5;
#elif KERNEL == KERNEL_DISK
const float CUT = 2.0;
#else
const float CUT = 1.0;
#endif

// Standard deviation of the blur along an axis, in pixels.
float blur_at(ivec2 pixel) {
#ifdef EFFECT_DIFFUSION
    return sqrt(read_beta(pixel).a) * UNIT;
#else
    return 0.0;
#endif
}

ivec2 within(ivec2 pixel) { return clamp(pixel, ivec2(0), ivec2(frame_size) - 1); }

// Bilinear, edges repeated.
vec3 interpolated(vec2 at) {
    vec2 texel = at - 0.5;
    ivec2 corner = ivec2(floor(texel));
    vec2 part = texel - vec2(corner);
    vec3 low = mix(read_opaque_color(within(corner)).rgb,
                   read_opaque_color(within(corner + ivec2(1, 0))).rgb, part.x);
    vec3 high = mix(read_opaque_color(within(corner + ivec2(0, 1))).rgb,
                    read_opaque_color(within(corner + ivec2(1, 1))).rgb, part.x);
    return mix(low, high, part.y);
}

// Weight of a tap at squared distance `square` that itself blurs over `blur` pixels. The floor of
// one pixel serves taps that a bend has brought to where nothing blurs.
float tap_weight(float square, float blur) {
#if KERNEL == KERNEL_GAUSSIAN
    return exp(-0.5 * square / max(blur * blur, 1.0));
#else
    return 1.0 / max(blur * blur, 1.0) + 1e-5;
#endif
}

// A tap counts only where it and the center both blur that far: sharp objects in front of a frosted
// pane stay out of its blur.
vec3 blurred(ivec2 center, float blur) {
    float largest = LIMIT == LIMIT_LISTING ? LISTING : RADIUS * float(frame_size.y);
    int reach = int(min(CUT * blur, largest)) / STRIDE * STRIDE;
    vec4 sum = vec4(0.0);
    for (int y = -reach; y <= reach; y += STRIDE) {
        for (int x = -reach; x <= reach; x += STRIDE) {
            float square = float(x * x + y * y);
            ivec2 tap = within(center + ivec2(x, y));
            float there = blur_at(tap);
            float shared_reach = CUT * min(blur, there);
            if (square <= shared_reach * shared_reach) {
                vec3 light = read_opaque_color(tap).rgb;
                sum += tap_weight(square, there) * vec4(light, 1.0);
            }
        }
    }
    return sum.rgb / max(sum.a, 1e-20);
}
