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

// A point moved off its surface along the normal `side`, by two texels of the depth map, so that the
// surface does not shadow itself.
vec3 off_surface(int i, vec3 position, vec3 side) {
    float span = beams[i].place.w == 0.0 ? 1.0 : dot(beams[i].distance, vec4(position, 1.0));
    return position + 2.0 * beams[i].color.w * span * side;
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

// Of moments of transparent surfaces alone, and the weight b of the light that they block. A point
// `inside` is itself a part of what the map holds, such as a particle of smoke.
float occluder_visibility(sampler2D map, vec2 place, float distance, bool inside) {
    vec3 sums = filtered_moments(map, place);
    float b = min(sums.z, 1.0);
    if (b <= 0.0) {
        return 1.0;
    }
    vec2 moments = sums.xy / sums.z;
    return 1.0 - b + b * moment_visibility(moments.x, moments.y, distance, inside ? 0.5 : 0.0);
}

// Texel and plane of a point among the slices of a beam, which begin at the distance `first`. A
// surface is moved toward the light, so that it does not shadow itself.
vec3 slice_place(int i, vec3 position, vec3 side, bool inside, float first, float thickness) {
    vec3 off = inside ? vec3(0.0) : float(DOWNSAMPLING) * (off_surface(i, position, side) - position);
    MapPlace at = place_in_map(i, position + off);
    return vec3(at.uv, (at.distance - first) / thickness - (inside ? 0.0 : 1.0));
}

// Fraction of the light at a place, linear between planes. Behind the last one nothing blocks light.
float slice_visibility(sampler3D map, vec3 place) {
    float planes = float(textureSize(map, 0).z);
    return textureLod(map, vec3(place.xy, (place.z + 0.5) / planes), 0.0).r;
}
#endif

// Samplers and `beam_visibility(i, position, side, inside)` follow, one case per beam.
