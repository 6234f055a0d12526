// Depths of a stochastic map to moments (z, z^2) of the distance along the light's axis; zero where
// there is no surface. In the published form the nearest opaque surface counts too, else a third
// component says whether there is a surface.
void resolve() {
    float depth = read_map();
#if defined(OPAQUE) && !defined(OCCLUDERS)
    depth = max(depth, read_opaque());
#endif
    float z = depth > 0.0 ? view_distance(depth) : 0.0;
#ifdef OCCLUDERS
    moments = vec4(z, z * z, depth > 0.0 ? 1.0 : 0.0, 0.0);
#else
    moments = vec2(z, z * z);
#endif
}
