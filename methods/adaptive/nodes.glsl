// The curve in targets: two nodes to a target as floats, or four packed, with 24 bits of the
// depth's float and 8 bits of transmittance each. A fragment meets packed nodes at the depth that
// they hold, or it would be hidden by its own.
#include "curve.glsl"

#ifdef PACKED

const uint DEPTH_BITS = 0xFFFFFF00u;

float packed_depth(float depth) {
    return uintBitsToFloat((floatBitsToUint(depth) << 1 & DEPTH_BITS) >> 1);
}

uint pack_node(int i) {
    uint through = uint(node_through[i] * 255.0 + 0.5);
    return (floatBitsToUint(node_depth[i]) << 1 & DEPTH_BITS) | through;
}

void unpack_nodes(int i, uvec4 nodes) {
    for (int k = 0; k < 4; ++k) {
        if (4 * i + k < NODES) {
            node_depth[4 * i + k] = uintBitsToFloat((nodes[k] & DEPTH_BITS) >> 1);
            node_through[4 * i + k] = float(nodes[k] & ~DEPTH_BITS) / 255.0;
        }
    }
}

uvec4 packed_nodes(int i) {
    uvec4 nodes = uvec4(0u);
    for (int k = 0; k < 4; ++k) {
        if (4 * i + k < NODES) {
            nodes[k] = pack_node(4 * i + k);
        }
    }
    return nodes;
}

#else

float packed_depth(float depth) { return depth; }

void unpack_nodes(int i, vec4 nodes) {
    node_depth[2 * i] = nodes.x;
    node_through[2 * i] = nodes.y;
    if (2 * i + 1 < NODES) {
        node_depth[2 * i + 1] = nodes.z;
        node_through[2 * i + 1] = nodes.w;
    }
}

vec4 packed_nodes(int i) {
    vec4 nodes = vec4(node_depth[2 * i], node_through[2 * i], 0.0, 0.0);
    if (2 * i + 1 < NODES) {
        nodes.zw = vec2(node_depth[2 * i + 1], node_through[2 * i + 1]);
    }
    return nodes;
}

#endif
