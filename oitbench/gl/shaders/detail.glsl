// Reflection, refraction and diffusion of a fragment of a mesh.

// The unit normal on the viewer's side; that of the triangle where the mesh gives none.
vec3 facing_normal(vec3 position, vec3 toward) {
    vec3 flat_normal = cross(dFdx(position), dFdy(position));
    vec3 normal = dot(v_normal, v_normal) > 0.0 ? v_normal : flat_normal;
    normal = normalize(dot(normal, normal) > 0.0 ? normal : toward);
    return dot(normal, toward) < 0.0 ? -normal : normal;
}

// Adds reflection, and the properties of refraction and diffusion. `position` is relative to the
// camera.
void add_reflection(inout Fragment fragment, vec3 position, vec3 normal, vec3 toward,
                    vec2 gradient) {
    Surface surface = surface_at(int(v_material + 0.5));
#ifdef VARIED
    surface.albedo *= varied.albedo;
    surface.roughness *= varied.roughness;
#endif
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
    fragment.radiance += reflected(surface, position, normal, toward, openness,
                                   transmittance(fragment)) * radiance_gain;
}
