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

// The center of a variance map's texel, as a fraction of a texel beyond its middle: the tent's middle
// tap is the third of four texels (shadow_tent.glsl).
const float BEYOND_MIDDLE = 0.125;

// Chebyshev's bound on the fraction of the light that reaches `distance`, of moments (z, z^2).
float variance_visibility(sampler2D map, vec2 place, float distance) {
    vec2 shift = BEYOND_MIDDLE / vec2(textureSize(map, 0));
    vec2 moments = textureLod(map, place - shift, 0.0).rg;
    float variance = max(moments.y - moments.x * moments.x, 1e-5 * moments.x * moments.x);
    float behind = distance - moments.x;
    return behind <= 0.0 ? 1.0 : variance / (variance + behind * behind);
}

// Samplers and `beam_visibility(i, position, normal)` follow, one case per beam.
