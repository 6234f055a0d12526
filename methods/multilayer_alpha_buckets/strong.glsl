// The nearest distances of a fragment that is not faint, and of one that counts as opaque.
void gather(Fragment fragment) {
    float o = net_opacity(fragment);
    strong = vec2(o > float(LOWER) ? fragment.z : 3e38, o >= float(OPAQUE) ? fragment.z : 3e38);
}
