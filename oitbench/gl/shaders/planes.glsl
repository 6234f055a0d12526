// The depth of coincident surfaces: equal planes have equal numbers, and so equal bits.
// dot(v_plane, (slopes, 1)) is the inverse view distance, 1/m; the view distance where rays are
// parallel. 0: no such plane.
flat in vec3 v_plane;

float inverse_depth_of_plane() {
    vec2 slopes = (gl_FragCoord.xy - 0.5 * vec2(frame_size)) / pixel_focal;
    precise float nearness = dot(v_plane, vec3(slopes, 1.0));
    precise float linear = (far_plane - nearness) / (far_plane - near_plane);
    precise float ratio = near_plane / far_plane;
    precise float depth = eye.w == 0.0 ? linear : (near_plane * nearness - ratio) / (1.0 - ratio);
    return v_plane == vec3(0.0) ? gl_FragCoord.z : clamp(depth, 0.0, 1.0);
}
