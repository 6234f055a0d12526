// The opaque picture behind all transparency. It is 1 where only transmittance is seen.
void gather(Fragment fragment) {
    color = vec4(radiance_gain > 0.0 ? fragment.radiance : vec3(1.0), 1.0);
}
