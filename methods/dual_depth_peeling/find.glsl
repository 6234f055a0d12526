// The nearest and the farthest fragment: edges is (-near, far), and blending takes the maximum.
// A fragment without effect is no layer.
void gather(Fragment fragment) {
    if (fragment.coverage <= 0.0) {
        discard;
    }
    edges = vec2(-fragment.depth, fragment.depth);
}
