// The visibility curve of one pixel: nodes in front-to-back order, each a depth and the
// transmittance behind it. Empty nodes lie at FAR and carry the running total, so the last node
// always has the total. Loops are of constant length, 32 at most: compilers unroll them.
#include "curves/channels.glsl"

const float FAR = 1.7014118346046923e38;  // 2^127, which packing leaves as it is
const int HALF = NODES / 2;
const vec2 NOTHING_BEFORE = vec2(0.0, 1.0);
float node_depth[NODES + 1];
float node_through[NODES + 1];

void begin_curve() {
    for (int i = 0; i < NODES; ++i) {
        node_depth[i] = FAR;
        node_through[i] = 1.0;
    }
    node_depth[NODES] = FAR;
    node_through[NODES] = 1.0;
}

// Takes the corner of depth `depth_gone` and transmittance `through_gone` out of the curve.
void take_out(int depth_gone, int through_gone) {
    for (int i = 0; i < NODES; ++i) {
        node_depth[i] = i < depth_gone ? node_depth[i] : node_depth[i + 1];
        node_through[i] = i < through_gone ? node_through[i] : node_through[i + 1];
    }
    node_depth[NODES] = FAR;
}

// Computes by how much removing node i would change the curve's integral, and keeps the least;
// `front` is the node in front of it (AT eq. 7 and section 3.2).
void weigh(int i, vec2 front, inout float least, inout ivec2 gone) {
    float drop = front.y - node_through[i];
#if REMOVAL != REMOVAL_OVER
    // The node in front takes over the transmittance: an underestimate between the two.
    float under = drop * (node_depth[i] - front.x);
    if (i > 0 && under <= least) {
        least = under;
        gone = ivec2(i, i - 1);
    }
#endif
#if REMOVAL != REMOVAL_UNDER
    // The node goes as a whole: an overestimate up to the next. The last one holds the total.
    float over = drop * (node_depth[min(i + 1, NODES)] - node_depth[i]);
    if (i < NODES && over <= least) {
        least = over;
        gone = ivec2(i, i);
    }
#endif
}

// Removes one of NODES + 1 nodes; with an empty one left, that one, and the curve stays as it is.
void compress() {
    float least = node_depth[NODES] < FAR ? FAR : -1.0;
    ivec2 gone = ivec2(NODES);
    // In two loops: compilers would not unroll as long a one.
    for (int i = NODES; i > HALF; --i) {
        weigh(i, vec2(node_depth[i - 1], node_through[i - 1]), least, gone);
    }
    for (int i = HALF; i > 0; --i) {
        weigh(i, vec2(node_depth[i - 1], node_through[i - 1]), least, gone);
    }
    weigh(0, NOTHING_BEFORE, least, gone);
    take_out(gone.x, gone.y);
}

// Shifts node i one place on if it lies behind `depth`, or puts the new node at its place.
void shift(int i, vec2 front, float depth, float factor) {
    bool behind = node_depth[i] >= depth;
    node_through[i] = behind ? front.y * factor : node_through[i];
    node_depth[i] = max(front.x, min(node_depth[i], depth));
}

// Multiplies the curve by a step at `depth`: all that lies behind is seen through `factor`.
void insert(float depth, float factor) {
    for (int i = NODES; i > 0; --i) {
        shift(i, vec2(node_depth[i - 1], node_through[i - 1]), depth, factor);
    }
    shift(0, NOTHING_BEFORE, depth, factor);
    compress();
}

// Transmittance of all that is nearer than `depth`.
float visibility(float depth) {
    float through = 1.0;
    for (int i = 0; i < NODES; ++i) {
        through = node_depth[i] < depth ? node_through[i] : through;
    }
    return through;
}

float total() { return node_through[NODES - 1]; }
