// The nearest and the farthest fragment: edges is (-near, far), and blending takes the maximum.
void gather(Fragment fragment) {
    edges = vec2(-fragment.depth, fragment.depth);
}
