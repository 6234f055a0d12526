// The hardware turns the opacity into a mask of samples, which keep the color undiminished.
void gather(Fragment fragment) {
    vec4 layer = premultiplied(fragment);
    if (layer.a <= 0.0) {
        discard;
    }
    color = vec4(layer.rgb / layer.a, layer.a);
}
