// Sorts every list once, before each sample of its pixel goes through it.
#include "sort_list.glsl"

void resolve() {
    uint first = list_first();
    if (list_owner() && first != NONE) {
        first = sort_list(first);
#if STORAGE == STORAGE_LINKED
        set_heads_first(pixel_index(), first);
#endif
    }
}
