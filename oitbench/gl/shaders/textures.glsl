// The texture filter that both renderers share (oitbench/scene/texturing.py), texel by texel: hardware
// rounds levels and weights of its own filters. Slots: oitbench/gl/surface_textures.py.
uniform sampler2DArray surface_textures;   // premultiplied (emission * coverage, coverage)

// Bilinear between the centers of the texels of one mip level; edges repeat.
vec4 filtered_level(vec2 uv, int slot, int level) {
    ivec2 size = max(ivec2(TEXTURE_WIDTH, TEXTURE_HEIGHT) >> level, ivec2(1));
    vec2 at = clamp(uv * vec2(size), vec2(0.5), vec2(size) - 0.5) - 0.5;
    ivec2 low = ivec2(at), high = min(low + 1, size - 1);
    vec2 part = at - vec2(low);
    int side = max(TEXTURE_WIDTH, TEXTURE_HEIGHT) >> level;
    ivec2 corner = side * ivec2(slot % SLOTS_ACROSS, slot / SLOTS_ACROSS % SLOTS_UP);
    int layer = slot / (SLOTS_ACROSS * SLOTS_UP);
    low += corner;
    high += corner;
    vec4 below = mix(texelFetch(surface_textures, ivec3(low, layer), level),
                     texelFetch(surface_textures, ivec3(high.x, low.y, layer), level), part.x);
    vec4 above = mix(texelFetch(surface_textures, ivec3(low.x, high.y, layer), level),
                     texelFetch(surface_textures, ivec3(high, layer), level), part.x);
    return mix(below, above, part.y);
}

// Needs derivatives: call it outside any branch.
vec4 filtered_texel(vec2 uv, int slot) {
    vec2 size = vec2(TEXTURE_WIDTH, TEXTURE_HEIGHT);
    vec2 dx = dFdx(uv) * size;
    vec2 dy = dFdy(uv) * size;
    float last = floor(log2(max(size.x, size.y)) + 0.5);
    float lod = clamp(0.5 * log2(max(max(dot(dx, dx), dot(dy, dy)), 1e-20)), 0.0, last);
    int level = int(lod);
    vec4 fine = filtered_level(uv, slot, level);
    vec4 coarse = filtered_level(uv, slot, min(level + 1, int(last)));
    return mix(fine, coarse, lod - float(level));
}
