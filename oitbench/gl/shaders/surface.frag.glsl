// Shades one fragment of a mesh and passes it to the method.
in vec2 v_uv;
in vec3 v_radiance;
in float v_z;
in vec3 v_position;
flat in vec3 v_transmission;
flat in float v_coverage;
flat in float v_layer;
in vec3 v_normal;
flat in float v_material;

#ifdef TEXTURED
uniform sampler2DArray surface_textures;   // premultiplied (emission * coverage, coverage)

// Trilinear lookup in two exact levels: drivers may round their level of detail, and the path tracer
// must filter the same texels.
vec4 filtered_texel(vec2 uv, float layer) {
    vec2 size = vec2(textureSize(surface_textures, 0).xy);
    vec2 dx = dFdx(uv) * size;
    vec2 dy = dFdy(uv) * size;
    float levels = float(textureQueryLevels(surface_textures));
    float lod = clamp(0.5 * log2(max(max(dot(dx, dx), dot(dy, dy)), 1e-20)), 0.0, levels - 1.0);
    float level = floor(lod);
    vec4 fine = textureLod(surface_textures, vec3(uv, layer), level);
    vec4 coarse = textureLod(surface_textures, vec3(uv, layer), min(level + 1.0, levels - 1.0));
    return mix(fine, coarse, lod - level);
}
#endif

#ifdef INTERIOR
// Filtered binary coverage of at least this is opaque.
const float WHOLE = 254.0 / 255.0;
#endif

#ifdef DETAILED
// The unit normal on the viewer's side; that of the triangle where the mesh gives none.
vec3 facing_normal(vec3 toward) {
    vec3 flat_normal = cross(dFdx(v_position), dFdy(v_position));
    vec3 normal = dot(v_normal, v_normal) > 0.0 ? v_normal : flat_normal;
    normal = normalize(dot(normal, normal) > 0.0 ? normal : toward);
    return dot(normal, toward) < 0.0 ? -normal : normal;
}

// Adds reflection, and the properties of refraction and diffusion.
void add_reflection(inout Fragment fragment, vec3 normal, vec3 toward, vec2 gradient) {
    Surface surface = surface_at(int(v_material + 0.5));
    float openness = 1.0;
#ifdef OCCLUSION
    openness = openness_of(surface, fragment.coverage, gradient, fragment.z);
#endif
    fragment.normal = normal;
    fragment.incidence = dot(normal, toward);
    fragment.index = surface.index;
    fragment.collimation = surface.collimation;
    vec3 kept = 1.0 - surface.albedo;
    fragment.transmission *= kept * (1.0 - fresnel(surface.reflectance, fragment.incidence));
    fragment.radiance += reflected(surface, v_position, normal, toward, openness) * radiance_gain;
}
#endif

void main() {
    Fragment fragment;
    fragment.radiance = v_radiance * radiance_gain;
    fragment.coverage = v_coverage;
    fragment.transmission = v_transmission;
    fragment.z = v_z;
    fragment.depth = gl_FragCoord.z;
    fragment.position = v_position;
    fragment.normal = vec3(0.0);
    fragment.incidence = 1.0;
    fragment.index = 1.0;
    fragment.entering = gl_FrontFacing;
    fragment.collimation = 1.0;
    // Outside any branch, and before any discard: derivatives need the whole quad.
#ifdef DETAILED
    vec3 toward = normalize(eye.xyz - eye.w * v_position);
    vec3 normal = facing_normal(toward);
#endif
    vec2 gradient = vec2(0.0);   // of the coverage, a pixel
#ifdef TEXTURED
    vec4 texel = filtered_texel(v_uv, max(v_layer, 0.0));
    vec2 slope = vec2(dFdx(texel.a), dFdy(texel.a));
    if (v_layer >= 0.0) {
        gradient = v_coverage * slope;
        if (texel.a <= 0.0) {
            discard;
        }
        fragment.radiance *= texel.rgb / texel.a;
        fragment.coverage *= texel.a;
    }
#endif
#ifdef INTERIOR
    if (fragment.coverage < WHOLE) {
        discard;
    }
#endif
#ifdef DETAILED
    add_reflection(fragment, normal, toward, gradient);
#endif
    DELIVER(fragment)
}
