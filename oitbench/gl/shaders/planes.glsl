// The depth of coincident surfaces: equal planes have equal numbers, and so equal bits.
flat in vec3 v_plane;   // inverse view distance = dot(v_plane, (slopes, 1)), 1/m; 0: no such plane

float inverse_depth_of_plane() {
    vec2 slopes = (gl_FragCoord.xy - 0.5 * vec2(frame_size)) / pixel_focal;
    precise float nearness = dot(v_plane, vec3(slopes, 1.0));
    precise float ratio = near_plane / far_plane;
    precise float depth = (near_plane * nearness - ratio) / (1.0 - ratio);
    return v_plane == vec3(0.0) ? gl_FragCoord.z : clamp(depth, 0.0, 1.0);
}
