// Marks the blocks with a pixel in which a layer is left.
void resolve() {
    ivec2 first = ivec2(gl_FragCoord.xy) * BLOCK;
    ivec2 end = min(first + BLOCK, textureSize(bounds_texture, 0));
    left = 0.0;
    for (int y = first.y; y < end.y; ++y) {
        for (int x = first.x; x < end.x; ++x) {
            vec2 edges = read_bounds(ivec2(x, y));
            left = edges.x >= -edges.y ? 1.0 : left;
        }
    }
}
