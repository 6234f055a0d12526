// Lists of either kind, and the order of layers: by depth, ties by content, never by arrival.
#include "linked_lists/record.glsl"

#if STORAGE == STORAGE_COUNTED

uint list_end;

// The first record of the pixel's list, or NONE.
uint list_first() {
    uvec2 head = read_heads();
    list_end = head.x + min(head.y, read_stored());
    return head.x < list_end ? head.x : NONE;
}

// The record behind `node`, or NONE.
uint list_next(uint node) { return node + 1u < list_end ? node + 1u : NONE; }

#else

uint list_first() { return heads_first(pixel_index()); }
uint list_next(uint node) { return nodes_next(node); }

#endif

bool nearer(Layer a, Layer b) {
    if (layer_depth(a) != layer_depth(b)) return layer_depth(a) < layer_depth(b);
#if NODE == NODE_PRECISE
    if (a.front.x != b.front.x) return a.front.x < b.front.x;
    if (a.front.y != b.front.y) return a.front.y < b.front.y;
    if (a.front.z != b.front.z) return a.front.z < b.front.z;
    if (a.front.w != b.front.w) return a.front.w < b.front.w;
    if (a.back.x != b.back.x) return a.back.x < b.back.x;
    return a.back.y < b.back.y;
#else
    return a.color < b.color;
#endif
}
