// The texture filter that both renderers share (oitbench/scene/texturing.py), texel by texel: hardware
// rounds levels and weights of its own filters. The store: oitbench/gl/surface_textures.py.
uniform sampler2DArray surface_textures;   // premultiplied (property * coverage, coverage), in a row
uniform isampler2D texture_levels;         // first texel, width, height, wraps + 16 * levels

ivec4 level_of_texture(int number) {
    return texelFetch(texture_levels, ivec2(number % LEVELS_ACROSS, number / LEVELS_ACROSS), 0);
}

vec4 stored_texel(int number) {
    int row = number / TEXELS_ACROSS;
    ivec3 at = ivec3(number % TEXELS_ACROSS, row % TEXELS_UP, row / TEXELS_UP);
    return texelFetch(surface_textures, at, 0);
}

#ifdef WRAPS
const int REPEAT = 1, MIRROR = 2;

float folded(float place, int wrap) {
    return wrap == REPEAT ? place - floor(place)
                          : wrap == MIRROR ? abs(place - 2.0 * round(0.5 * place)) : place;
}
#endif

// Bilinear between the centers of the texels of one mip level.
vec4 filtered_level(vec2 uv, ivec4 stored) {
    ivec2 size = stored.yz;
#ifdef WRAPS
    ivec2 wrap = ivec2(stored.w, stored.w >> 2) & 3;
    uv = vec2(folded(uv.x, wrap.x), folded(uv.y, wrap.y));
#endif
    vec2 at = clamp(uv * vec2(size), vec2(0.5), vec2(size) - 0.5) - 0.5;
    ivec2 low = ivec2(at), high = min(low + 1, size - 1);
    vec2 part = at - vec2(low);
#ifdef WRAPS
    vec2 free = uv * vec2(size) - 0.5;
    ivec2 start = ivec2(floor(free));
    bvec2 around = equal(wrap, ivec2(REPEAT));
    part = mix(part, free - vec2(start), around);
    low = mix(low, (start + size) % size, around);
    high = mix(high, (start + 1) % size, around);
#endif
    ivec2 rows = stored.x + ivec2(low.y, high.y) * size.x;
    vec4 below = mix(stored_texel(rows.x + low.x), stored_texel(rows.x + high.x), part.x);
    vec4 above = mix(stored_texel(rows.y + low.x), stored_texel(rows.y + high.x), part.x);
    return mix(below, above, part.y);
}

// `number` is that of the texture's first level. Needs derivatives: call it outside any branch.
vec4 filtered_texel(vec2 uv, int number) {
    ivec4 finest = level_of_texture(number);
    vec2 size = vec2(finest.yz);
    vec2 dx = dFdx(uv) * size;
    vec2 dy = dFdy(uv) * size;
    int last = (finest.w >> 4) - 1;
    float lod = clamp(0.5 * log2(max(max(dot(dx, dx), dot(dy, dy)), 1e-20)), 0.0, float(last));
    int level = int(lod);
    vec4 fine = filtered_level(uv, level_of_texture(number + level));
    vec4 coarse = filtered_level(uv, level_of_texture(number + min(level + 1, last)));
    return mix(fine, coarse, lod - float(level));
}
