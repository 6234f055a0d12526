// The distances of the nearest and farthest absorbing fragment, as (-nearest, farthest).
void gather(Fragment fragment) {
    bool absorbs = any(lessThan(transmittance(fragment), vec3(1.0)));
    bounds = absorbs ? vec2(-fragment.z, fragment.z) : vec2(-1e38);
}
