// Over, premultiplied: blending multiplies what is there by 1 - o.
void gather(Fragment fragment) {
    color = premultiplied(fragment);
}
