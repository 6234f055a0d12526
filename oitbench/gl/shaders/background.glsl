// The environment where no surface is.
void resolve() {
    if (read_opaque_depth() > 0.0) {
        discard;
    }
    color = vec4(environment_radiance(normalize(pixel_ray(gl_FragCoord.xy))), 1.0);
}
