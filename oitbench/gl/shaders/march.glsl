// A ray marched through the medium that fills a box (McGuire & Mara 2017, TVCG, section 7.2).
#include "hidden.glsl"
#include "medium.glsl"
#include "random.glsl"

// A thin part of the medium, composited like a surface.
struct Slice {
    vec3 radiance;    // L
    float coverage;   // alpha; a slice has no transmission
    float z;          // view distance of its middle, m
};

// The part of a pixel's view ray that lies inside the medium.
struct Path {
    vec3 origin;      // at view distance 0
    vec3 direction;   // its length advances one meter of view distance
    float enters;     // view distance, m
    float leaves;
};

// Henyey & Greenstein 1941, 1/sr; `cosine` is between the directions before and after.
float phase(float cosine) {
    float g = medium_high.w;
    float base = max(1.0 + g * g - 2.0 * g * cosine, 1e-12);
    return (1.0 - g * g) / (4.0 * PI * base * sqrt(base));
}

// Between the near plane and the view distance `behind`; `leaves` < `enters` if the ray misses.
Path path_through_medium(float behind) {
    vec3 direction = pixel_ray(gl_FragCoord.xy), origin = pixel_origin(gl_FragCoord.xy);
    vec3 safe = mix(direction, vec3(1e-12), lessThan(abs(direction), vec3(1e-12)));
    vec3 one = (medium_low.xyz - origin) / safe, other = (medium_high.xyz - origin) / safe;
    vec3 first = min(one, other), last = max(one, other);
    return Path(origin, direction, max(max(first.x, first.y), max(first.z, near_plane)),
                min(min(last.x, last.y), min(last.z, behind)));
}

// Radiance that scatters toward the eye at `position`, per extinguished light: from all sides, and from
// beams, which the medium dims in `steps` steps on their way.
vec3 scattered(vec3 position, vec3 onward, int steps) {
    vec3 sum = medium_ambient.rgb;
    for (int i = 0; i < BEAMS; ++i) {
        vec3 light = irradiance(i, position) * phase(dot(toward_light(i, position), onward));
        if (any(greaterThan(light, vec3(0.0)))) {
            Receiver receiver = Receiver(position, vec3(0.0), APART, vec3(1.0));
            sum += light * beam_visibility(i, receiver) * passing_medium(i, position, steps);
        }
    }
    return medium_color.rgb * sum * radiance_gain;
}

// Position inside a slice, in [0, 1), at which a pixel samples all of its slices: noise in place of
// bands. It is random per block of 4 x 4 pixels, and spread evenly over the pixels of a block and of
// each of its quarters (Bayer 1973).
float jitter() {
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    uint x = pixel.x ^ pixel.y, y = pixel.y;
    uint rank = (x & 1u) * 8u + (y & 1u) * 4u + (x >> 1 & 1u) * 2u + (y >> 1 & 1u);
    return fract(float(rank) / 16.0 + unit_interval(hash(uvec3(pixel / 4u, 0)).x));
}

// Slice `k` of `count` of equal thickness; light and density are sampled at the fraction `part`, and
// the medium dims beams in `steps` steps.
Slice slice_of(Path path, int k, int count, float part, int steps) {
    float thickness = max(path.leaves - path.enters, 0.0) / float(count);
    float begins = path.enters + float(k) * thickness;
    vec3 position = path.origin + (begins + part * thickness) * path.direction;
    float meters = length(path.direction) * thickness;
    float coverage = hidden_by(medium_low.w * density_at(position) * meters);
    vec3 onward = normalize(path.direction);
    vec3 radiance = coverage > 0.0 ? scattered(position, onward, steps) : vec3(0.0);
    return Slice(radiance, coverage, begins + 0.5 * thickness);
}
