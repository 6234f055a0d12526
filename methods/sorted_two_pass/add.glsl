// Second half: the surface's own light.
void gather(Fragment fragment) {
    color = vec4(fragment.coverage * fragment.radiance, 0.0);
}
