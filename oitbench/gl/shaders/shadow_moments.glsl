// Depths of a stochastic map to moments (z, z^2) of the distance along the light's axis, of the
// nearest surface, opaque ones included; (0, 0) where there is none.
float axial_distance(float depth) {
    return eye.w == 0.0 ? far_plane - depth * (far_plane - near_plane) : view_distance(depth);
}

void resolve() {
    float depth = read_map();
#ifdef OPAQUE
    depth = max(depth, read_opaque());
#endif
    float z = depth > 0.0 ? axial_distance(depth) : 0.0;
    moments = vec2(z, z * z);
}
