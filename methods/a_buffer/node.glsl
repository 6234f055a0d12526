// The order of layers: by depth, ties by content, never by arrival. And batches of layers, held field
// by field: llvmpipe miscompiles local arrays of structures.
#include "linked_lists/record.glsl"

const int BATCH = 32;
float batch_stored[BATCH];

#if NODE == NODE_PRECISE

vec4 batch_front[BATCH];
vec2 batch_back[BATCH];

Layer batch_layer(int i) { return Layer(batch_stored[i], batch_front[i], batch_back[i]); }

void set_batch_layer(int i, Layer layer) {
    batch_stored[i] = layer.stored;
    batch_front[i] = layer.front;
    batch_back[i] = layer.back;
}

bool nearer(Layer a, Layer b) {
    if (layer_depth(a) != layer_depth(b)) return layer_depth(a) < layer_depth(b);
    if (a.front.x != b.front.x) return a.front.x < b.front.x;
    if (a.front.y != b.front.y) return a.front.y < b.front.y;
    if (a.front.z != b.front.z) return a.front.z < b.front.z;
    if (a.front.w != b.front.w) return a.front.w < b.front.w;
    if (a.back.x != b.back.x) return a.back.x < b.back.x;
    return a.back.y < b.back.y;
}

#else

uint batch_color[BATCH];

Layer batch_layer(int i) { return Layer(batch_stored[i], batch_color[i]); }

void set_batch_layer(int i, Layer layer) {
    batch_stored[i] = layer.stored;
    batch_color[i] = layer.color;
}

bool nearer(Layer a, Layer b) {
    if (layer_depth(a) != layer_depth(b)) return layer_depth(a) < layer_depth(b);
    return a.color < b.color;
}

#endif
