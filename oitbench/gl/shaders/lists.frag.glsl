// Reads one fragment of a given list and passes it to the method.
INSIDE in vec3 v_radiance;
flat in float v_layer;

uniform sampler2DArray list_radiance;       // L, alpha
uniform sampler2DArray list_transmission;   // t, z

void main() {
    // LISTS layers stand above each other in each layer of the texture.
    ivec3 stored = textureSize(list_radiance, 0);
    uvec2 size = uvec2(stored.x, stored.y / LISTS);
    int layer = int(v_layer);
    ivec3 texel = ivec3(uvec2(gl_FragCoord.xy) * size / frame_size, layer % stored.z);
    texel.y += layer / stored.z * int(size.y);
    vec4 radiance = texelFetch(list_radiance, texel, 0);
    vec4 transmission = texelFetch(list_transmission, texel, 0);
    Fragment fragment;
    fragment.radiance = radiance.rgb * radiance_gain;
    fragment.coverage = radiance.a;
    fragment.transmission = transmission.rgb;
    fragment.z = transmission.a;
    fragment.inverse_depth = inverse_depth_at(fragment.z);
    fragment.depth = window_depth(fragment.inverse_depth);
    fragment.position = vec3(gl_FragCoord.xy, fragment.z);
    fragment.normal = vec3(0.0, 0.0, 1.0);
    fragment.incidence = 1.0;
    fragment.index = 1.0;
    fragment.entering = true;
    fragment.collimation = 1.0;
#ifdef OWN_DEPTH
    gl_FragDepth = fragment.inverse_depth;
#endif
    DELIVER(fragment)
}
