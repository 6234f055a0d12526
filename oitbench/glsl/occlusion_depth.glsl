// Distances from the depth of opaque surfaces, interiors of binary coverage included.

// Linear view distance in m; that of the far plane, or of nothing, is very large.
float surface_distance(float depth) {
    return near_plane / max(1.0 - depth * (1.0 - near_plane / far_plane), 1e-9);
}
