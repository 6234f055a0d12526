// The exact transmittance of all layers.
void gather(Fragment fragment) {
    total = net_opacity(fragment);
}
