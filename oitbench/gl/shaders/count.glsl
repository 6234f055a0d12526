// Depth complexity: how many transparent fragments each pixel has.
void gather(Fragment fragment) {
    count = 1.0;
}
