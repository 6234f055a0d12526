// The gathered radiance, over the background seen through all layers.
void resolve() {
    color = vec4(read_sum().rgb, 1.0);
    color_factor = vec4(read_through().rgb, 0.0);
}
