// Marks the blocks with a pixel in which the pass has found a layer.
void resolve() {
    ivec2 first = ivec2(gl_FragCoord.xy) * BLOCK;
    ivec2 end = min(first + BLOCK, textureSize(layer_texture, 0));
    left = 0.0;
    for (int y = first.y; y < end.y; ++y) {
        for (int x = first.x; x < end.x; ++x) {
            left = max(left, read_layer(ivec2(x, y)).a);
        }
    }
}
