void gather(Fragment fragment) {
    sum = premultiplied(fragment);
}
