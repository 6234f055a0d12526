// The environment where no surface is.
void resolve() {
    if (read_opaque_depth() < 1.0) {
        discard;
    }
    vec2 ndc = 2.0 * gl_FragCoord.xy / vec2(frame_size) - 1.0;
    vec2 half_width = vec2(frame_size) / (2.0 * pixel_focal);
    vec3 direction = transpose(mat3(world_to_camera)) * vec3(ndc * half_width, -1.0);
    color = vec4(environment_radiance(normalize(direction), 0.0), 1.0);
}
