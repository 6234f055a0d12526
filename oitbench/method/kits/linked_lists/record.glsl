// The record of a list. Methods with lists have the parameters `node` and `msaa`; those with
// `channels` keep colored transmission in compact records as well.

#if NODE == NODE_PRECISE

struct Layer {
    float stored;  // depth; with multisampling its low four bits are the samples covered
    vec4 front;    // alpha L, tau.r
    vec2 back;     // tau.gb
};

// The record whose depth is known.
Layer load_layer(uint node, float stored) {
    return Layer(stored, nodes_front(node), nodes_back(node));
}

void store_layer(uint node, float stored, vec3 color, vec3 factor, float net_opacity) {
    set_nodes_depth(node, stored);
    set_nodes_front(node, vec4(color, factor.r));
    set_nodes_back(node, factor.gb);
}

void move_layer(uint node, Layer layer) {
    set_nodes_depth(node, layer.stored);
    set_nodes_front(node, layer.front);
    set_nodes_back(node, layer.back);
}

vec3 layer_color(Layer layer) { return layer.front.rgb; }
vec3 layer_factor(Layer layer) { return vec3(layer.front.a, layer.back); }

#else

#ifdef CHANNELS_RGB
#define TINTED (CHANNELS == CHANNELS_RGB)
#else
#define TINTED 0
#endif

struct Layer {
    float stored;  // depth; with multisampling its low four bits are the samples covered
    uint color;    // alpha L, net opacity; 8 bits each
#if TINTED
    uint factor;   // tau; 8 bits each
#endif
};

// The record whose depth is known.
Layer load_layer(uint node, float stored) {
#if TINTED
    return Layer(stored, nodes_color(node), nodes_factor(node));
#else
    return Layer(stored, nodes_color(node));
#endif
}

void store_layer(uint node, float stored, vec3 color, vec3 factor, float net_opacity) {
    set_nodes_depth(node, stored);
    set_nodes_color(node, packUnorm4x8(vec4(color, net_opacity)));
#if TINTED
    set_nodes_factor(node, packUnorm4x8(vec4(factor, 0.0)));
#endif
}

void move_layer(uint node, Layer layer) {
    set_nodes_depth(node, layer.stored);
    set_nodes_color(node, layer.color);
#if TINTED
    set_nodes_factor(node, layer.factor);
#endif
}

vec3 layer_color(Layer layer) { return unpackUnorm4x8(layer.color).rgb; }

vec3 layer_factor(Layer layer) {
#if TINTED
    return unpackUnorm4x8(layer.factor).rgb;
#else
    return vec3(1.0 - unpackUnorm4x8(layer.color).a);
#endif
}

#endif

Layer load_layer(uint node) { return load_layer(node, nodes_depth(node)); }

#if MSAA > 1

const uint SAMPLES = 0xFu;

float with_mask(float depth) {
    return uintBitsToFloat((floatBitsToUint(depth) & ~SAMPLES) | coverage_mask());
}

float layer_depth(Layer layer) { return uintBitsToFloat(floatBitsToUint(layer.stored) & ~SAMPLES); }

// Whether the layer covers the sample that is being shaded.
bool layer_seen(Layer layer) { return (floatBitsToUint(layer.stored) & coverage_mask()) != 0u; }

// Whether this invocation is the one of its pixel that may change the list.
bool list_owner() { return coverage_mask() == 1u; }

#else

float with_mask(float depth) { return depth; }
float layer_depth(Layer layer) { return layer.stored; }
bool layer_seen(Layer layer) { return true; }
bool list_owner() { return true; }

#endif
