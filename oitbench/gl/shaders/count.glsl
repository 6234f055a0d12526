// Depth complexity: the number of transparent fragments in each pixel.
void gather(Fragment fragment) {
    count = 1.0;
}
