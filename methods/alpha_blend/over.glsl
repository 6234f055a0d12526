// Over, premultiplied: blending multiplies the target by 1 - o.
void gather(Fragment fragment) {
    color = premultiplied(fragment);
}
