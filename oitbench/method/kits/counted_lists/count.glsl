// Counts the fragments of a pixel.
void gather(Fragment fragment) {
    count_stored();
}
