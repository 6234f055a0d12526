// Stores a fragment in the next record of its pixel, by view distance.
#include "linked_lists/record.glsl"

void gather(Fragment fragment) {
    uvec2 head = read_heads();
    uint place = count_stored();
    if (place < head.y) {
        store_layer(head.x + place, with_mask(fragment.z), fragment.coverage * fragment.radiance,
                    transmittance(fragment), net_opacity(fragment));
    }
}
