// One vertex shader for every pass that rasterizes geometry, so that depths agree bit for bit.
// INSIDE and PLACED say where values are taken if pixels have several samples.
in vec3 in_position;   // relative to the camera, m
in vec2 in_uv;
in vec3 in_radiance;
in vec3 in_transmission;
in float in_coverage;
in float in_layer;
in vec3 in_normal;
in float in_material;

#ifdef PLANES
in vec3 in_plane;
flat out vec3 v_plane;
#endif

#ifdef VERTEX_FACTORS
in vec3 in_albedo;
in vec3 in_passing;
in float in_part;
INSIDE out vec3 v_albedo;
INSIDE out vec3 v_passing;
INSIDE out float v_part;
#endif

PLACED out vec2 v_uv;
INSIDE out vec3 v_radiance;
INSIDE out vec3 v_position;
flat out vec3 v_transmission;
flat out float v_coverage;
flat out float v_layer;
INSIDE out vec3 v_normal;
flat out float v_material;
#ifdef OF_SEVERAL
INSIDE out float v_one;
#endif
invariant gl_Position;

void main() {
#ifdef LISTS
    // A list's layer covers the frame; its depths come from a texture.
    gl_Position = vec4(in_position.xy, 1.0, 1.0);
#else
    gl_Position = vertex_to_clip * vec4(in_position, 1.0);
#endif
#ifdef PLANES
    v_plane = in_plane;
#endif
#ifdef VERTEX_FACTORS
    v_albedo = in_albedo;
    v_passing = in_passing;
    v_part = in_part;
#endif
#ifdef OF_SEVERAL
    // Always one: compilers do not interpolate constants.
    v_one = in_material < 1e9 ? 1.0 : 0.0;
#endif
    v_position = in_position;
    v_uv = in_uv;
    v_radiance = in_radiance;
    v_transmission = in_transmission;
    v_coverage = in_coverage;
    v_layer = in_layer;
    v_normal = in_normal;
    v_material = in_material;
}
