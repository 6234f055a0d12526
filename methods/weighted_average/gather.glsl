void gather(Fragment fragment) {
    sum = premultiplied(fragment);
    number = sum.a > 0.0 ? 1.0 : 0.0;
}
