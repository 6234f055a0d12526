// Depths of a stochastic map to moments (z, z^2) of the distance along the light's axis, of the
// nearest surface, opaque ones included; (0, 0) where there is none.
float axial_distance(float depth) {
    return eye.w == 0.0 ? near_plane + depth * (far_plane - near_plane)
                        : near_plane * far_plane / (far_plane - depth * (far_plane - near_plane));
}

void resolve() {
    float depth = read_map();
#ifdef OPAQUE
    depth = min(depth, read_opaque());
#endif
    float z = depth < 1.0 ? axial_distance(depth) : 0.0;
    moments = vec2(z, z * z);
}
