// First half: the background passes through the surface.
void gather(Fragment fragment) {
    color = vec4(transmittance(fragment), 1.0);
}
