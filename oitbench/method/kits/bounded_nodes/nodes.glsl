// Nodes of a pixel's bounded list: K of them, in the targets `depths` and `colors` of
// oitbench/method/kits/bounded_nodes. A node's color is alpha L and net opacity o, premultiplied:
// opacity, not transmittance, keeps thin layers distinct in half floats, and white furnaces white.
// The nearest half float: drivers round in different ways, some toward zero.
float half_float(float x) {
    uint bits = floatBitsToUint(clamp(x, 0.0, 65504.0));
    return uintBitsToFloat((bits + 0xFFFu + ((bits >> 13) & 1u)) & 0xFFFFE000u);
}
vec4 half_float(vec4 v) {
    return vec4(half_float(v.x), half_float(v.y), half_float(v.z), half_float(v.w));
}

#if NODE == NODE_8_BIT

#define Color uint
const int WORDS = 1;
Color pack(vec4 color) { return packUnorm4x8(color); }
vec4 unpack(Color color) { return unpackUnorm4x8(color); }
bool less(Color a, Color b) { return a < b; }
bool hides_nothing(Color color) { return color == 0u; }

#elif NODE == NODE_16F

#define Color uvec2
const int WORDS = 2;
Color pack(vec4 color) {
    color = half_float(color);
    return uvec2(packHalf2x16(color.rg), packHalf2x16(color.ba));
}
vec4 unpack(Color color) { return vec4(unpackHalf2x16(color.x), unpackHalf2x16(color.y)); }
bool less(Color a, Color b) { return a.x < b.x || (a.x == b.x && a.y < b.y); }
bool hides_nothing(Color color) { return color == uvec2(0u); }

#else

#define Color uvec4
const int WORDS = 4;
Color pack(vec4 color) { return floatBitsToUint(color); }
vec4 unpack(Color color) { return uintBitsToFloat(color); }
bool less(Color a, Color b) {
    if (a.x != b.x) return a.x < b.x;
    if (a.y != b.y) return a.y < b.y;
    return a.z < b.z || (a.z == b.z && a.w < b.w);
}
bool hides_nothing(Color color) { return color == uvec4(0u); }

#endif

struct Node {
    uint depth;    // bits of the view distance in meters, which sort as it does
    Color color;
};

uint part(uint texel, int i) { return texel; }
uint part(uvec2 texel, int i) { return texel[i]; }
uint part(uvec4 texel, int i) { return texel[i]; }

// Word `j` of a node's color: four words to a target.
uint color_word(int i, int j) { return part(FETCH_COLORS((i * WORDS + j) / 4), (i * WORDS + j) % 4); }

Node node_at(int i) {
    uint depth = part(FETCH_DEPTHS(i / 4), i % 4);
#if NODE == NODE_8_BIT
    return Node(depth, color_word(i, 0));
#elif NODE == NODE_16F
    return Node(depth, uvec2(color_word(i, 0), color_word(i, 1)));
#else
    return Node(depth, FETCH_COLORS(i));
#endif
}

// Loops over many targets are not unrolled by all compilers, and each access then branches over all
// targets: four times as slow on llvmpipe at K = 16. So they are written out.
#define EACH_1(step) step(0)
#define EACH_2(step) EACH_1(step) step(1)
#define EACH_4(step) EACH_2(step) step(2) step(3)
#define EACH_8(step) EACH_4(step) step(4) step(5) step(6) step(7)
#define EACH_16(step) EACH_8(step) step(8) step(9) step(10) step(11) \
    step(12) step(13) step(14) step(15)
#if K == 1
#define EACH_NODE EACH_1
#elif K == 2
#define EACH_NODE EACH_2
#elif K == 4
#define EACH_NODE EACH_4
#elif K == 8
#define EACH_NODE EACH_8
#else
#define EACH_NODE EACH_16
#endif
