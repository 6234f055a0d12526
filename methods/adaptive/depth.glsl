// The depth that curves are made in.
float curve_depth(Fragment fragment) {
#if DEPTH == DEPTH_WINDOW
    return fragment.depth;
#else
    return fragment.z;
#endif
}
