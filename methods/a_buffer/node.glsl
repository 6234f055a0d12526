// What a record holds, and the order of records: by depth, ties by content, never by arrival.
// Batches are held field by field: llvmpipe miscompiles local arrays of structures.
const int BATCH = 32;
float batch_depth[BATCH];

#if NODE == NODE_PRECISE

struct Layer {
    float depth;   // m
    vec4 front;    // alpha L, tau.r
    vec2 back;     // tau.gb
};

Layer load_layer(uint node) {
    return Layer(nodes_depth(node), nodes_front(node), nodes_back(node));
}

void store_layer(uint node, vec3 color, vec3 factor, float net_opacity, float depth) {
    set_nodes_depth(node, depth);
    set_nodes_front(node, vec4(color, factor.r));
    set_nodes_back(node, factor.gb);
}

vec3 layer_color(Layer layer) { return layer.front.rgb; }
vec3 layer_factor(Layer layer) { return vec3(layer.front.a, layer.back); }

vec4 batch_front[BATCH];
vec2 batch_back[BATCH];

Layer batch_layer(int i) { return Layer(batch_depth[i], batch_front[i], batch_back[i]); }

void set_batch_layer(int i, Layer layer) {
    batch_depth[i] = layer.depth;
    batch_front[i] = layer.front;
    batch_back[i] = layer.back;
}

bool nearer(Layer a, Layer b) {
    if (a.depth != b.depth) return a.depth < b.depth;
    if (a.front.x != b.front.x) return a.front.x < b.front.x;
    if (a.front.y != b.front.y) return a.front.y < b.front.y;
    if (a.front.z != b.front.z) return a.front.z < b.front.z;
    if (a.front.w != b.front.w) return a.front.w < b.front.w;
    if (a.back.x != b.back.x) return a.back.x < b.back.x;
    return a.back.y < b.back.y;
}

#else

struct Layer {
    float depth;   // m
    uint color;    // alpha L, net opacity; 8 bits each
};

Layer load_layer(uint node) {
    return Layer(nodes_depth(node), nodes_color(node));
}

void store_layer(uint node, vec3 color, vec3 factor, float net_opacity, float depth) {
    set_nodes_depth(node, depth);
    set_nodes_color(node, packUnorm4x8(vec4(color, net_opacity)));
}

vec3 layer_color(Layer layer) { return unpackUnorm4x8(layer.color).rgb; }
vec3 layer_factor(Layer layer) { return vec3(1.0 - unpackUnorm4x8(layer.color).a); }

uint batch_color[BATCH];

Layer batch_layer(int i) { return Layer(batch_depth[i], batch_color[i]); }

void set_batch_layer(int i, Layer layer) {
    batch_depth[i] = layer.depth;
    batch_color[i] = layer.color;
}

bool nearer(Layer a, Layer b) {
    return a.depth < b.depth || (a.depth == b.depth && a.color < b.color);
}

#endif
