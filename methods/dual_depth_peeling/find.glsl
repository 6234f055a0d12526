// The nearest and the farthest fragment: edges is (near, -far) in inverse depth, and blending takes the maximum.
// A fragment without effect is no layer.
void gather(Fragment fragment) {
    if (fragment.coverage <= 0.0) {
        discard;
    }
    edges = vec2(fragment.inverse_depth, -fragment.inverse_depth);
}
