// Shades one fragment of a mesh and hands it to the method.
in vec2 v_uv;
in vec3 v_radiance;
in float v_z;
in vec3 v_position;
flat in vec3 v_transmission;
flat in float v_coverage;
flat in float v_layer;

#ifdef TEXTURED
uniform sampler2DArray surface_textures;   // premultiplied (emission * coverage, coverage)

// Trilinear lookup in two exact levels: drivers are free to round their own level of detail, and
// the path tracer has to meet the same texels.
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

void main() {
    Fragment fragment;
    fragment.radiance = v_radiance * radiance_gain;
    fragment.coverage = v_coverage;
    fragment.transmission = v_transmission;
    fragment.z = v_z;
    fragment.depth = gl_FragCoord.z;
    fragment.position = v_position;
#ifdef TEXTURED
    // Outside the branch: derivatives need the whole quad.
    vec4 texel = filtered_texel(v_uv, max(v_layer, 0.0));
    if (v_layer >= 0.0) {
        if (texel.a <= 0.0) {
            discard;
        }
        fragment.radiance *= texel.rgb / texel.a;
        fragment.coverage *= texel.a;
    }
#endif
    deliver(fragment);
}
