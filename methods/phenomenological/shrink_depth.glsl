// The opaque depth at one pixel of each block. A mean would lie where there is no surface.
#include "model.glsl"

void resolve() {
    ivec2 block = ivec2(gl_FragCoord.xy) * SUBSAMPLE;
    // One at the block's center; the frame may end before it.
    ivec2 full = textureSize(opaque_depth_texture, 0);
    float depth = read_opaque_depth(min(block + SUBSAMPLE / 2, full - 1));
#ifdef OWN_DEPTH
    gl_FragDepth = depth;
#endif
    small_distance = view_distance(depth);
}
