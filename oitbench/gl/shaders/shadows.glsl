// The fraction of a beam that arrives: opaque maps (Williams 1978), and variance maps of stochastic
// colored shadows (McGuire & Mara 2017, section 4.6; Donnelly & Lauritzen 2006).

// Distance along the axis that a map's depth encodes, m.
float map_distance(int i, float depth) {
    float near = beams[i].range.x, far = beams[i].range.y;
    return beams[i].place.w == 0.0 ? far - depth * (far - near)
                                   : near / mix(depth, 1.0, near / far);
}

struct MapPlace {
    vec2 uv;
    float distance;   // along the axis, m
    bool inside;      // whether the map covers the point
};

// Where a point lies in a beam's maps.
MapPlace place_in_map(int i, vec3 position) {
    vec4 clip = beams[i].to_map * vec4(position, 1.0);
    vec2 ndc = clip.xy / clip.w;
    bool inside = clip.w > 0.0 && all(lessThan(abs(ndc), vec2(1.0)));
    return MapPlace(0.5 + 0.5 * ndc, dot(beams[i].distance, vec4(position, 1.0)), inside);
}

// What is lit.
struct Receiver {
    vec3 position;
    vec3 side;   // unit normal; zero for a medium
    int kind;    // one of the following
    vec3 tau;    // its own transmittance
};

// Whether maps of transparent surfaces hold the receiver itself.
const int APART = 0;      // no
const int SHEET = 1;      // yes
const int PARTICLE = 2;   // yes, as one of many that together are a volume

// The receiver moved off its surface along its normal, by some texels of the depth map, so that the
// surface does not shadow itself.
vec3 off_surface(int i, Receiver receiver, float texels) {
    vec3 position = receiver.position;
    float span = beams[i].place.w == 0.0 ? 1.0 : dot(beams[i].distance, vec4(position, 1.0));
    return position + texels * beams[i].color.w * span * receiver.side;
}

// Fraction of the light that passes the nearest opaque surface, interpolated between four texels.
float opaque_visibility(sampler2D map, int i, MapPlace place) {
    ivec2 size = textureSize(map, 0);
    vec2 texel = place.uv * vec2(size) - 0.5;
    ivec2 corner = ivec2(floor(texel));
    vec4 lit;
    for (int k = 0; k < 4; ++k) {
        ivec2 at = clamp(corner + ivec2(k & 1, k >> 1), ivec2(0), size - 1);
        float depth = texelFetch(map, at, 0).r;
        lit[k] = depth <= 0.0 || place.distance <= map_distance(i, depth) ? 1.0 : 0.0;
    }
    vec2 part = texel - vec2(corner);
    return mix(mix(lit.x, lit.y, part.x), mix(lit.z, lit.w, part.x), part.y);
}

#ifdef DOWNSAMPLING
// The filtered moments of a variance map. The center of its texel lies beyond its middle by half a
// texel of the depth map if the tent's middle tap does (shadow_tent.glsl).
vec3 filtered_moments(sampler2D map, vec2 place) {
    float beyond = DOWNSAMPLING > 1 ? 0.5 / float(DOWNSAMPLING) : 0.0;
    return textureLod(map, place - beyond / vec2(textureSize(map, 0)), 0.0).rgb;
}

// Fraction of the light that reaches `distance` by moments (z, z^2). Behind their mean, it is between
// 0 and Chebyshev's bound w; before it, between 1 - w and 1. `own` is 0 for the greatest value, and
// 1/2 for the middle.
float moment_visibility(float mean, float square, float distance, float own) {
    float variance = max(square - mean * mean, 1e-5 * mean * mean);
    float behind = distance - mean;
    float bound = variance / (variance + behind * behind);
    return behind <= 0.0 ? 1.0 - own * bound : (1.0 - own) * bound;
}

// Of moments that include the nearest opaque surface (McGuire & Mara 2017).
float published_visibility(sampler2D map, vec2 place, float distance) {
    vec3 moments = filtered_moments(map, place);
    return moment_visibility(moments.x, moments.y, distance, 0.0);
}

// Of moments of transparent surfaces alone, and the weight b of the light that they block.
float occluder_visibility(sampler2D map, vec2 place, float distance, int kind) {
    vec3 sums = filtered_moments(map, place);
    float b = min(sums.z, 1.0);
    if (b <= 0.0) {
        return 1.0;
    }
    vec2 moments = sums.xy / sums.z;
    float own = kind == PARTICLE ? 0.5 : 0.0;
    return 1.0 - b + b * moment_visibility(moments.x, moments.y, distance, own);
}

// Texel and plane of a receiver among the slices of a beam, which begin at the distance `first`. A
// sheet is moved by one slice toward the light, and off its surface.
vec3 slice_place(int i, Receiver receiver, float first, float thickness) {
    bool sheet = receiver.kind == SHEET;
    float texels = sheet ? 2.0 * float(DOWNSAMPLING) : 0.0;
    MapPlace at = place_in_map(i, off_surface(i, receiver, texels));
    return vec3(at.uv, (at.distance - first) / thickness - (sheet ? 1.0 : 0.0));
}

// Fraction of the light that reaches a place, linear between planes. A particle has a part in the
// light at the plane behind it, which is divided by its own transmittance.
float slice_visibility(sampler3D map, vec3 place, int kind, float own) {
    float planes = float(textureSize(map, 0).z);
    float before = floor(place.z);
    float near = textureLod(map, vec3(place.xy, (before + 0.5) / planes), 0.0).r;
    float far = textureLod(map, vec3(place.xy, (before + 1.5) / planes), 0.0).r;
    far = kind == PARTICLE ? min(far / max(own, 1e-3), near) : far;
    return mix(near, far, place.z - before);
}
#endif

// Samplers and `beam_visibility(i, receiver)` follow, one case per beam.
