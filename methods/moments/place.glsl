// The place of a layer in [-1, 1], and the moments of a unit of absorbance there.
const int HALF = COUNT / 2;
const float TURN = 6.283185307179586;
const float WRAP = 0.1 * 0.5 * TURN;  // angle without layers, between the last place and the first

float place_of(Fragment fragment) {
#if DEPTH == DEPTH_LOG
    float range = log(transparent_range.y / transparent_range.x);
    return clamp(2.0 * log(fragment.z / transparent_range.x) / max(range, 1e-6) - 1.0, -1.0, 1.0);
#elif DEPTH == DEPTH_LINEAR
    vec2 bounds = read_bounds();
    float range = max(bounds.x + bounds.y, 1e-6);
    return clamp(2.0 * (fragment.z + bounds.x) / range - 1.0, -1.0, 1.0);
#else
    return clamp(2.0 * fragment.depth - 1.0, -1.0, 1.0);
#endif
}

float angle_of(float x) { return 0.5 * (x + 1.0) * (TURN - WRAP); }

vec2 times(vec2 a, vec2 b) { return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x); }
vec2 conjugate(vec2 a) { return vec2(a.x, -a.y); }

// Powers x, x^2 ... or cosines and sines of one, two ... angles.
float[COUNT] moments_at(float x) {
    float found[COUNT];
#if BASIS == BASIS_POWER
    float power = x;
    for (int j = 0; j < COUNT; ++j) {
        found[j] = power;
        power *= x;
    }
#else
    vec2 base = vec2(cos(angle_of(x)), sin(angle_of(x)));
    vec2 power = base;
    for (int k = 0; k < HALF; ++k) {
        found[2 * k] = power.x;
        found[2 * k + 1] = power.y;
        power = times(power, base);
    }
#endif
    return found;
}
