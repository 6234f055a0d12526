// Records each transparent fragment of the drawn pixels, with its place in the order of draws.
void gather(Fragment fragment) {
    uint record = allocate_fragments();
    if (record != NONE) {
        set_fragments_draw(record, uint(gl_PrimitiveID));
        set_fragments_light(record, vec4(fragment.radiance, fragment.coverage));
        set_fragments_glass(record, vec4(fragment.transmission, fragment.z));
    }
}
